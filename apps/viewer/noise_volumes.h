// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Solid textures that repeat, so that tissue has detail on any surface, cut faces included,
/// without texture coordinates.

#include <cstdint>
#include <vector>

namespace cholecystectomy {

/// Texels along a side of a volume.
inline constexpr int kNoiseSize = 64;

/// Features along a side: one feature is 1 / kNoiseCells of the volume.
inline constexpr int kNoiseCells = 8;

/// Two octaves of gradient noise (Perlin 2002, "Improving noise"). Texel: gradient (rgb) and value
/// (a), 0..255 for -1..1.
/// @return  [kNoiseSize^3 * 4] x fastest
[[nodiscard]] std::vector<std::uint8_t> make_gradient_noise();

/// Cellular noise (Worley 1996, "A cellular texture basis function"). Texel: vector from the
/// nearest seed (rgb, -1..1 cells) and the distance to the cell's border (a, -1..1 for 0..1 cells).
/// @return  [kNoiseSize^3 * 4] x fastest
[[nodiscard]] std::vector<std::uint8_t> make_cell_noise();

}  // namespace cholecystectomy
