// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which triangles or edges of a body may be near something: a tree of boxes, fitted to where they
/// are.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/contact_bodies.h"
#include "lib/solver/state/particle.h"
#include "lib/solver/state/touch_lists.h"

namespace pbdsurg {

/// Around some places; it holds nothing where one of them is not finite.
[[nodiscard]] TouchBox box_of(std::span<const Index> places, std::span<const Particle> positions);

/// Orders triangles or edges along a Morton curve. Cost: O(n log n).
/// @param triangles  [n] by places
/// @param positions  [place] m
PBDSURG_API void order(std::span<const ContactBodies::PlaceTriangle> triangles,
                       std::span<const Particle> positions, TouchTree& tree);
PBDSURG_API void order(std::span<const ContactBodies::Edge> edges,
                       std::span<const Particle> positions, TouchTree& tree);

/// Fits the boxes. What is not finite is nowhere. Cost: O(n).
void fit_boxes(std::span<const ContactBodies::PlaceTriangle> triangles,
               std::span<const Particle> positions, TouchTree& tree);
void fit_boxes(std::span<const ContactBodies::Edge> edges, std::span<const Particle> positions,
               TouchTree& tree);

/// Triangles or edges of a leaf, at most.
inline constexpr std::size_t kLeafSize = 4;

/// Calls visit(i) for each triangle or edge in a leaf whose box is within reach of another box.
/// @param reach  m
template <class Visit>
void visit_near(const TouchTree& tree, const TouchBox& other, float reach, const Visit& visit) {
  const auto is_near = [&](const TouchBox& box) {
    return box.low.x - reach <= other.high.x && other.low.x <= box.high.x + reach &&  //
           box.low.y - reach <= other.high.y && other.low.y <= box.high.y + reach &&  //
           box.low.z - reach <= other.high.z && other.low.z <= box.high.z + reach;
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
    const std::size_t first = (node - tree.first_leaf) * kLeafSize;
    const std::size_t end = std::min(first + kLeafSize, tree.order.size());
    for (std::size_t i = first; i < end; ++i) {
      visit(tree.order[i]);
    }
  }
}

}  // namespace pbdsurg
