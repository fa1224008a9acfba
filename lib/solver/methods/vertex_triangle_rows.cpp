// SPDX-License-Identifier: Apache-2.0
// How the triangles of sheets lie in the rows of their vertices.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg {

void VertexBlocks::find_triangles(Index vertex) {
  for (const Index t : triangles_at(vertex)) {
    const VertexTriangle& triangle = given_triangles_[t];
    if (!(triangle.stiffness > 0)) {
      continue;
    }
    const auto here = std::ranges::find(triangle.vertices, vertex) - triangle.vertices.begin();
    const auto a = static_cast<std::size_t>(here + 1) % 3,
               b = static_cast<std::size_t>(here + 2) % 3;
    neighborhood_.triangles.push_back({{triangle.vertices[a], triangle.vertices[b]},
                                       {triangle.weights[b], triangle.weights[a]},
                                       triangle.stiffness,
                                       triangle.target,
                                       triangle.area_damping});
    if (triangle.edge_damping[0] > 0) {
      add_dashpot(triangle.vertices[a], triangle.edge_damping[b]);
      add_dashpot(triangle.vertices[b], triangle.edge_damping[a]);
    }
  }
}

// Along an edge of triangles: one for each neighbour, as pulls are.
void VertexBlocks::add_dashpot(Index neighbor, float damping) {
  const auto known = std::ranges::find_if(neighborhood_.springs, [&](const Spring& spring) {
    return spring.neighbor == neighbor && spring.stiffness == 0;
  });
  if (known == neighborhood_.springs.end()) {
    neighborhood_.springs.push_back({neighbor, 0, 0, damping});
  } else {
    known->damping += damping;
  }
}

void VertexBlocks::write_triangles(const VertexBlock& block, Index lane, Index count) noexcept {
  const std::vector<Area>& triangles = neighborhood_.triangles;
  const Index vertex = place_at(block.corners[lane]);
  const Area padding{{vertex, vertex}, {0, 0}, 0, 0, 0};
  for (Index i = 0; i < count; ++i) {
    const Area& area = i < static_cast<Index>(triangles.size()) ? triangles[i] : padding;
    TriangleRow& row = triangles_[block.triangles.first + i];
    for (int k = 0; k < 2; ++k) {
      row.neighbors[k][lane] = offset_of(area.neighbors[k]);
      row.weights[k][lane] = area.weights[k];
    }
    row.stiffness[lane] = area.stiffness;
    row.target[lane] = area.target;
    if (has_damping_) {
      DampedRow& damped = damped_triangles_[block.triangles.first + i];
      damped.stiffness[lane] = area.stiffness;
      damped.target[lane] = area.target;
      damped.damping[lane] = area.damping;
    }
  }
}

}  // namespace pbdsurg
