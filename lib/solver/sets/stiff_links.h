// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which links vertex blocks cannot take as springs.

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// Whether a link is a StiffLinkConstraint: with vertex blocks, where it is more than ten times as
/// stiff as the softer of its ends. As a spring it would take that many more sweeps.
[[nodiscard]] bool is_stiff_link(const Tissue& tissue, Index link, const SolverOptions& options);

}  // namespace pbdsurg
