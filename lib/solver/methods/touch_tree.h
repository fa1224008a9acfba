// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which triangles of a body may be near a point: a tree of boxes, fitted to where they are.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/particle.h"
#include "lib/solver/state/tissue_touch.h"

namespace pbdsurg {

/// Orders triangles along a Morton curve. Cost: O(n log n).
/// @param triangles  [n] by places
/// @param positions  [place] m
void order_triangles(std::span<const std::array<Index, 3>> triangles,
                     std::span<const Particle> positions, TouchTree& tree);

/// Fits the boxes. Triangles that are not finite are nowhere. Cost: O(n).
void fit_boxes(std::span<const std::array<Index, 3>> triangles, std::span<const Particle> positions,
               TouchTree& tree);

/// Triangles of a leaf, at most.
inline constexpr std::size_t kLeafTriangles = 4;

/// Calls visit(triangle) for each in a leaf whose box is within reach of a point.
/// @param reach  m
template <class Visit>
void visit_near(const TouchTree& tree, const Vec3<float>& x, float reach, const Visit& visit) {
  const auto is_near = [&](const TouchBox& box) {
    return box.low.x - reach <= x.x && x.x <= box.high.x + reach &&  //
           box.low.y - reach <= x.y && x.y <= box.high.y + reach &&  //
           box.low.z - reach <= x.z && x.z <= box.high.z + reach;
  };
  std::array<std::size_t, 64> waiting;  // two a level of a balanced tree
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const std::size_t node = waiting[--count];
    if (node >= tree.boxes.size() || !is_near(tree.boxes[node])) {
      continue;
    }
    if (node < tree.first_leaf) {
      waiting[count++] = 2 * node + 2;
      waiting[count++] = 2 * node + 1;
      continue;
    }
    const std::size_t first = (node - tree.first_leaf) * kLeafTriangles;
    const std::size_t end = std::min(first + kLeafTriangles, tree.order.size());
    for (std::size_t i = first; i < end; ++i) {
      visit(tree.order[i]);
    }
  }
}

}  // namespace pbdsurg
