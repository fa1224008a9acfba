// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/boundary_check.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {
namespace {

// A boundary edge with the two triangle corners at its ends; corner 3 t + i is vertex i of t.
struct BoundarySide {
  Edge edge;
  Index first_corner, second_corner;
};

Index find_root(std::vector<Index>& parent, Index i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

}  // namespace

BoundaryCheck check_boundary(Index point_count, std::span<const Tet> tets) {
  std::vector<Triangle> triangles;
  for (const BoundaryTriangle& triangle : find_boundary(tets)) {
    triangles.push_back(triangle.vertices);
  }
  std::vector<BoundarySide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const Index a = triangles[t][i], b = triangles[t][j];
      const auto corner = static_cast<Index>(3 * t);
      sides.push_back(a < b ? BoundarySide{{a, b}, corner + i, corner + j}
                            : BoundarySide{{b, a}, corner + j, corner + i});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const BoundarySide& a, const BoundarySide& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.first_corner < b.first_corner;
  });

  // Corners at one vertex that meet across an edge belong to one fan.
  BoundaryCheck check;
  std::vector<Index> fan(3 * triangles.size());
  std::iota(fan.begin(), fan.end(), 0);
  const auto join = [&fan](Index a, Index b) {
    a = find_root(fan, a);
    b = find_root(fan, b);
    fan[std::max(a, b)] = std::min(a, b);
  };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) {
      join(sides[i].first_corner, sides[end].first_corner);
      join(sides[i].second_corner, sides[end].second_corner);
      ++end;
    }
    if (end - i != 2) {
      check.pinched_edges.push_back(sides[i].edge);
    }
    i = end;
  }
  std::vector<Index> fans_at(static_cast<std::size_t>(point_count), 0);
  for (std::size_t corner = 0; corner < fan.size(); ++corner) {
    if (fan[corner] == static_cast<Index>(corner)) {
      ++fans_at[triangles[corner / 3][corner % 3]];
    }
  }
  for (Index v = 0; v < point_count; ++v) {
    if (fans_at[v] > 1) {
      check.pinched_vertices.push_back(v);
    }
  }
  check.shells = find_components(point_count, triangles).count;

  // each inner triangle has two tetrahedra, so 2 F = 4 T + boundary triangles
  const auto tet_count = static_cast<int>(tets.size());
  const auto edge_count = static_cast<int>(find_edges(tets).size());
  check.euler = point_count - edge_count +
                (4 * tet_count + static_cast<int>(triangles.size())) / 2 - tet_count;
  return check;
}

}  // namespace pbdsurg
