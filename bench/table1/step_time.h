// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long a step takes whose constraints are coloured in a given way.

#include <array>

#include "pbdsurg/solver/solver.h"

#include "sample.h"

namespace pbdsurg::bench {

/// A backend and its column.
struct StepBackend {
  BackendKind kind;
  const char* key;
  const char* title;
};
inline constexpr std::array<StepBackend, 1> kStepBackends{
    {{BackendKind::serial, "serial_ms", "step (serial), ms"}}};

using StepTimes = std::array<double, kStepBackends.size()>;  ///< ms

/// Median time of one step on each backend: the paper's mode (30 sweeps) at 0.2 ms, one rim fixed,
/// from a start that is stretched by 10 %.
/// @throws Error  if a step leaves a vertex that is not finite
[[nodiscard]] StepTimes time_steps(const Sample& sample, const ColoringOptions& coloring,
                                   PlanComposition composition, int repetitions);

}  // namespace pbdsurg::bench
