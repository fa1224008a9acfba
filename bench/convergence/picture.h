// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The curves as a picture, where this build can draw.

#include <filesystem>

#include "bench/convergence/report.h"

namespace pbdsurg::bench {

/// Writes the residual of one step, and residual and tip error on the way to rest, each over
/// milliseconds; of each method the best setting.
/// @throws BackendUnavailable  if this build cannot draw
/// @throws FileError           if the file cannot be written
void draw_curves(const Comparison& comparison, const std::filesystem::path& path);

}  // namespace pbdsurg::bench
