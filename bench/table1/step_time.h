// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long steps take whose constraints are coloured in different ways.

#include <array>
#include <span>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "support/sample.h"

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

/// Of both compositions of a plan.
struct PlanTimes {
  StepTimes separate;
  StepTimes joint;
};

/// Median time of one step for each colouring, plan and backend: the paper's mode (30 sweeps) at
/// 0.2 ms, one rim fixed, from a start that is stretched by 10 %. All take turns, so that a busy
/// machine slows all alike.
/// @return  [colorings.size()]
/// @throws Error  if a step leaves a vertex that is not finite
[[nodiscard]] std::vector<PlanTimes> time_steps(const Sample& sample,
                                                std::span<const ColoringOptions> colorings,
                                                int repetitions);

}  // namespace pbdsurg::bench
