// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a triangulated surface crosses itself.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

struct SurfaceCrossings {
  std::vector<std::pair<Index, Index>> pairs;  ///< triangles, the smaller id first, ascending
  bool complete = true;                        ///< false if the search ended before all were found
};

/// Finds all pairs of triangles with a point in common beyond their common corners and the edge
/// between two of these: those that pass through each other, fold onto each other, overlap in one
/// plane or touch. Pairs with three common corners coincide and are left out, as are triangles
/// without area.
///
/// Whether a point lies on a plane or a line is decided with a bound on the rounding of its
/// coordinates (32 units in the last place of the largest one), and then counts as touching: no
/// crossing is missed, and a surface in another unit gives the same pairs.
/// @param points     [n] finite, in any unit; points at one place must have one id
/// @param triangles  point ids, three different ones each
/// @note Cost: O(n log n) for surfaces whose triangles overlap the boxes of a few others; the
///       search ends after kCrossingComparisons for each triangle, or with kMostCrossings.
[[nodiscard]] SurfaceCrossings find_surface_crossings(std::span<const Eigen::Vector3d> points,
                                                      std::span<const Triangle> triangles);

/// Comparisons of two triangles that a search may take for each triangle, and for a mesh of few.
inline constexpr double kCrossingComparisons = 500;
inline constexpr double kLeastCrossingComparisons = 1e7;
inline constexpr std::size_t kMostCrossings = 1'000'000;

}  // namespace pbdsurg
