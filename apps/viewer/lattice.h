// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The points of a triangle whose edges are split into equal parts.

#include <array>
#include <cstdint>
#include <vector>

namespace cholecystectomy {

/// Many triangles of one pattern, for a vertex shader that places the points.
struct Lattice {
  /// Steps towards the first, second and third corner, and which triangle. The steps sum to the
  /// subdivision.
  std::vector<std::array<std::uint16_t, 4>> points;
  std::vector<std::uint16_t>
      indices;             ///< [3 * subdivision^2 * triangle_count], wound as the corners
  int triangle_count = 0;  ///< as many as 16-bit indices can name, at most `most`
};

/// @param subdivision  at least 1
[[nodiscard]] Lattice make_lattice(int subdivision, int most = 8192);

}  // namespace cholecystectomy
