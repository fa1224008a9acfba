// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Figure 8: the organ with each constraint in its colour, where this build can draw.

#include <filesystem>
#include <vector>

#include "bench/support/sample.h"

namespace pbdsurg::bench {

/// Writes figure8_KIND_ALGORITHM_distance.png and ..._volume.png for each of four colourings: edges
/// as lines, tetrahedra shrunken and cut open; and figure8_KIND.png with all of them.
/// @return  the last of these
/// @throws BackendUnavailable  if this build or this machine cannot draw
/// @throws FileError           if a file cannot be written
std::filesystem::path draw_figure8(const Sample& sample, const std::filesystem::path& folder);

}  // namespace pbdsurg::bench
