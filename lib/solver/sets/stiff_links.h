// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which links vertex blocks cannot take as springs.

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/stiff_link.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/sets/constraint_numbers.h"

namespace pbdsurg {

/// The numbers of a link, if it is a StiffLinkConstraint: with vertex blocks, where it is rigid, or
/// more than ten times as stiff as the softer of its ends and more than four times as the stiffer,
/// as these are now, in a substep of 1 ms. As a spring it would take that many more sweeps: both
/// ends would hold each other where they are. A softer end alone follows the other within a sweep.
[[nodiscard]] StiffLinkNumbers stiff_link_numbers(const Tissue& tissue, Index link,
                                                  const SolverOptions& options);

}  // namespace pbdsurg
