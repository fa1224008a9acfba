// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colouring on a CUDA device, where this build and this machine have one.

#include <optional>
#include <string>

#include "pbdsurg/coloring/color.h"

namespace pbdsurg::bench {

/// The device's name, or why there is none.
[[nodiscard]] std::string describe_gpu();

/// Median time of a colouring whose constraints and colours stay on the device, in ms; nothing
/// without a device, and for orders that are sequential by nature.
/// @param expected  the host's colouring
/// @throws Error  if the device's differs
[[nodiscard]] std::optional<double> time_gpu_coloring(const ConstraintVertices& constraints,
                                                      const ColoringOptions& options,
                                                      const Coloring& expected, int repetitions);

}  // namespace pbdsurg::bench
