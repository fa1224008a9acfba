// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A picture in memory.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cholecystectomy {

/// An 8-bit sRGB colour.
using Rgb8 = std::array<std::uint8_t, 3>;

/// 8-bit sRGB pixels, row by row from the top left.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< [height * width * 3]

  /// The colour of one pixel; (0, 0) is at the top left.
  [[nodiscard]] Rgb8 at(int x, int y) const {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
};

}  // namespace cholecystectomy
