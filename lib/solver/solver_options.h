// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver refuses of its options, whatever the scene is, and what they say in short.

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option that is out of range
void check_option_ranges(const SolverOptions& options);

/// @param options  with the method that was chosen
/// @throws InvalidArgument  naming the option that the method and the executor asked for would not
///                          read
void check_option_readers(const SolverOptions& options);

/// Whether rows of vertices move these, as they do vertex by vertex or all at once.
[[nodiscard]] inline bool moves_vertices(const SolverOptions& options) noexcept {
  return options.method == SolverMethod::vertex_block ||
         options.method == SolverMethod::explicit_steps;
}

/// Whether it does so all at once.
[[nodiscard]] inline bool is_explicit(const SolverOptions& options) noexcept {
  return options.method == SolverMethod::explicit_steps;
}

/// @param options  with the correction that was chosen
[[nodiscard]] inline bool has_coarse_correction(const SolverOptions& options) noexcept {
  return options.coarse_correction == CoarseCorrection::on;
}

}  // namespace pbdsurg
