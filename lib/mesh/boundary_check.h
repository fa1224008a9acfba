// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Topology of tetrahedra that were just made: is the boundary a manifold, and of what kind.

#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

struct BoundaryCheck {
  std::vector<Edge> pinched_edges;      ///< of more than two boundary triangles
  std::vector<Index> pinched_vertices;  ///< whose boundary triangles form more than one fan
  int shells = 0;                       ///< connected pieces of the boundary
  int euler = 0;                        ///< V - E + F - T

  [[nodiscard]] bool is_manifold() const {
    return pinched_edges.empty() && pinched_vertices.empty();
  }
};

/// @param point_count  number of points, all of them in use
[[nodiscard]] BoundaryCheck check_boundary(Index point_count, std::span<const Tet> tets);

}  // namespace pbdsurg
