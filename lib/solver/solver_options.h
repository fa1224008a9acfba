// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver refuses of its options, whatever the scene is.

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option that is out of range
void check_option_ranges(const SolverOptions& options);

/// @param options  with the method that was chosen
/// @throws InvalidArgument  naming the option that the method and the executor asked for would not
///                          read
void check_option_readers(const SolverOptions& options);

}  // namespace pbdsurg
