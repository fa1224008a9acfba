// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Whole frames as columns of a table.

#include <optional>

#include "bench/frames/measure.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// `heat`, `edit`, `solver`, `contact`, `readback`, `upload`, `picture`
[[nodiscard]] Json to_json(const FrameStages& stages);

/// An object of these keys; null if it was not measured.
[[nodiscard]] Json to_json(const std::optional<FrameTimes>& times);

}  // namespace pbdsurg::bench
