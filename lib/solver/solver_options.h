// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver refuses of its options, whatever the scene is.

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option that is out of range, or that the method and the
///                          backend asked for would not read
void check_options(const SolverOptions& options);

}  // namespace pbdsurg
