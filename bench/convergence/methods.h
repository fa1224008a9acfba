// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is compared.

#include "bench/convergence/measure.h"

namespace pbdsurg::bench {

/// All come to rest with thirty sweeps a step, vertex blocks with as many as suit them.
/// @param bar      outlives the methods
/// @param damping  1/s, see SolverOptions::damping
[[nodiscard]] std::vector<Method> make_methods(const Cantilever& bar, float damping, int threads);

}  // namespace pbdsurg::bench
