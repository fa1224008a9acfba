// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long steps take whose constraints are coloured in different ways.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "bench/support/sample.h"

namespace pbdsurg::bench {

/// Who steps, and its column.
struct StepBackend {
  bool is_gpu;
  DeviceStrategy strategy;  ///< of a device
  const char* key;
  const char* title;
};
inline constexpr std::array<StepBackend, 3> kStepBackends{
    {{false, DeviceStrategy::automatic, "serial_ms", "step (serial), ms"},
     {true, DeviceStrategy::automatic, "gpu_ms", "step (gpu), ms"},
     {true, DeviceStrategy::stream, "gpu_stream_ms", "step (gpu, one launch a phase), ms"}}};

/// ms; none without a device
using StepTimes = std::array<std::optional<double>, kStepBackends.size()>;

/// Of both compositions of a plan.
struct PlanTimes {
  StepTimes separate;
  StepTimes joint;
};

/// Median time of one step for each colouring, plan and backend: the paper's mode (30 sweeps) at
/// 0.2 ms, one rim fixed, from a start that is stretched by 10 %; on a device the second step from
/// there, as the first takes the start there. All take turns, so that a busy machine slows all
/// alike.
/// @param has_gpu  see why_no_gpu()
/// @return  [colorings.size()]
/// @throws Error  if a step leaves a vertex that is not finite, or ends otherwise when it is
///                repeated
[[nodiscard]] std::vector<PlanTimes> time_steps(const Sample& sample,
                                                std::span<const ColoringOptions> colorings,
                                                int repetitions, bool has_gpu);

}  // namespace pbdsurg::bench
