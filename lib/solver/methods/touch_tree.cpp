// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_tree.h"

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

constexpr TouchBox kNowhere{{kInfinity, kInfinity, kInfinity},
                            {-kInfinity, -kInfinity, -kInfinity}};

TouchBox around(const TouchBox& a, const TouchBox& b) {
  return {
      {std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
      {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

// The bits of ten, two apart.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000FF;
  bits = (bits | bits << 8) & 0x0300F00F;
  bits = (bits | bits << 4) & 0x030C30C3;
  return (bits | bits << 2) & 0x09249249;
}

std::span<const Index> corners_of(const ContactBodies::PlaceTriangle& triangle) {
  return triangle;
}
std::span<const Index> corners_of(const ContactBodies::Edge& edge) {
  return edge.ends;
}

template <class Element>
void order_elements(std::span<const Element> elements, std::span<const Particle> positions,
                    TouchTree& tree) {
  std::vector<TouchBox> boxes;
  TouchBox all = kNowhere;
  for (const Element& element : elements) {
    boxes.push_back(box_of(corners_of(element), positions));
    all = around(all, boxes.back());
  }
  const Vec3<float> size = all.high - all.low;
  const float longest = std::max({size.x, size.y, size.z});
  constexpr float kCells = 1023;
  const auto cell = [&](float low, float high, float start) {
    const float share = longest > 0 ? ((low + high) / 2 - start) / longest : 0.0F;
    return spread(static_cast<std::uint32_t>(kCells * std::clamp(share, 0.0F, 1.0F)));
  };
  std::vector<std::pair<std::uint32_t, Index>> keys;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const TouchBox& box = boxes[i];
    const bool is_somewhere = box.low.x <= box.high.x;
    const std::uint32_t key = !is_somewhere ? ~0U
                                            : cell(box.low.x, box.high.x, all.low.x) |
                                                  cell(box.low.y, box.high.y, all.low.y) << 1 |
                                                  cell(box.low.z, box.high.z, all.low.z) << 2;
    keys.emplace_back(key, static_cast<Index>(i));
  }
  std::ranges::sort(keys);
  tree.order.clear();
  for (const auto& key : keys) {
    tree.order.push_back(key.second);
  }
}

template <class Element>
void fit(std::span<const Element> elements, std::span<const Particle> positions, TouchTree& tree) {
  const std::size_t leaves = (tree.order.size() + kLeafSize - 1) / kLeafSize;
  tree.first_leaf = std::bit_ceil(std::max<std::size_t>(leaves, 1)) - 1;
  tree.boxes.assign(tree.first_leaf + leaves, kNowhere);
  for (std::size_t i = 0; i < tree.order.size(); ++i) {
    TouchBox& leaf = tree.boxes[tree.first_leaf + i / kLeafSize];
    leaf = around(leaf, box_of(corners_of(elements[tree.order[i]]), positions));
  }
  for (std::size_t node = tree.first_leaf; node-- > 0;) {
    for (const std::size_t child : {2 * node + 1, 2 * node + 2}) {
      if (child < tree.boxes.size()) {
        tree.boxes[node] = around(tree.boxes[node], tree.boxes[child]);
      }
    }
  }
}

}  // namespace

TouchBox box_of(std::span<const Index> places, std::span<const Particle> positions) {
  TouchBox box = kNowhere;
  for (const Index place : places) {
    const Vec3<float> x = load(positions[place]);
    if (!is_finite_way(x)) {
      return kNowhere;
    }
    box = around(box, {x, x});
  }
  return box;
}

void order(std::span<const ContactBodies::PlaceTriangle> triangles,
           std::span<const Particle> positions, TouchTree& tree) {
  order_elements(triangles, positions, tree);
}
void order(std::span<const ContactBodies::Edge> edges, std::span<const Particle> positions,
           TouchTree& tree) {
  order_elements(edges, positions, tree);
}

void fit_boxes(std::span<const ContactBodies::PlaceTriangle> triangles,
               std::span<const Particle> positions, TouchTree& tree) {
  fit(triangles, positions, tree);
}
void fit_boxes(std::span<const ContactBodies::Edge> edges, std::span<const Particle> positions,
               TouchTree& tree) {
  fit(edges, positions, tree);
}

}  // namespace pbdsurg
