// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/surface_check.h"

#include <algorithm>
#include <cstdint>

#include "lib/base/disjoint_sets.h"

namespace pbdsurg {
namespace {

/// One side of a triangle.
struct SurfaceSide {
  Edge edge;             // smaller id first
  std::uint32_t corner;  // 3 * triangle + place of the corner it starts from
  bool forward;          // runs from the smaller id to the larger
};

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

}  // namespace

SurfaceDefects find_surface_defects(Index vertex_count, std::span<const Triangle> triangles) {
  std::vector<SurfaceSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = triangles[t][k];
      const Index b = triangles[t][(k + 1) % 3];
      sides.push_back(
          {{std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(3 * t + k), a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const SurfaceSide& a, const SurfaceSide& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.corner < b.corner;
  });

  SurfaceDefects defects;
  DisjointSets pieces(triangles.size());    // joined through edges
  DisjointSets fans(3 * triangles.size());  // corners joined through edges at their vertex
  std::vector<bool> sound(triangles.size(), true);
  for (std::size_t begin = 0; begin < sides.size();) {
    const Edge edge = sides[begin].edge;
    std::size_t end = begin;
    for (; end < sides.size() && sides[end].edge == edge; ++end) {
      const SurfaceSide& first = sides[begin];
      const SurfaceSide& side = sides[end];
      pieces.join(first.corner / 3, side.corner / 3);
      const bool same = first.forward == side.forward;
      fans.join(first.corner, same ? side.corner : next_corner(side.corner));
      fans.join(next_corner(first.corner), same ? next_corner(side.corner) : side.corner);
    }
    if (end - begin == 1) {
      defects.open_edges.push_back(edge);
    } else if (end - begin > 2) {
      defects.overshared_edges.push_back(edge);
    } else if (sides[begin].forward == sides[begin + 1].forward) {
      defects.badly_wound_edges.push_back(edge);
    }
    if (end - begin != 2) {
      for (std::size_t s = begin; s < end; ++s) {
        sound[sides[s].corner / 3] = false;
      }
    }
    ++defects.edge_count;
    begin = end;
  }

  std::vector<bool> piece_sound(triangles.size(), true);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!sound[t]) {
      piece_sound[pieces.root(t)] = false;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    defects.shell_count += pieces.root(t) == t && piece_sound[t] ? 1 : 0;
  }

  std::vector<Index> fan_count(static_cast<std::size_t>(vertex_count), 0);
  for (std::size_t c = 0; c < 3 * triangles.size(); ++c) {
    if (fans.root(c) == c) {
      ++fan_count[triangles[c / 3][c % 3]];
    }
  }
  for (Index v = 0; v < vertex_count; ++v) {
    if (fan_count[v] > 1) {
      defects.pinched_vertices.push_back(v);
    }
  }
  return defects;
}

}  // namespace pbdsurg
