// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Defects of a triangulated surface that follow from its connectivity.

#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

struct SurfaceDefects {
  Index edge_count = 0;
  Index shell_count = 0;                ///< edge-connected pieces with two triangles at every edge
  std::vector<Edge> open_edges;         ///< of one triangle
  std::vector<Edge> overshared_edges;   ///< of three or more
  std::vector<Edge> badly_wound_edges;  ///< of two that run it in the same direction
  std::vector<Index> pinched_vertices;  ///< whose triangles are more than one fan, ascending
};

/// Cost: O(n log n). Corners of a triangle must differ.
[[nodiscard]] SurfaceDefects find_surface_defects(Index vertex_count,
                                                  std::span<const Triangle> triangles);

}  // namespace pbdsurg
