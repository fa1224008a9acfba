// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A hierarchy of bounding boxes.

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Boxes split at the median of their centres, along the longest side, down to leaves of a few.
class BoxTree {
 public:
  static constexpr int kLeafSize = 4;
  static constexpr int kMaxDepth = 64;  // of a median split of at most 2^31 boxes

  struct Node {
    Eigen::AlignedBox3d box;
    Index first = 0, count = 0;  // into order()
    Index left = kInvalidIndex;  // the right child follows; none for leaves
  };

  BoxTree() = default;

  /// @param boxes      [n], none empty
  /// @param centers    [n] what decides to which half a box goes
  /// @param summarize  called with the members of each node, in the order of nodes(), before they
  ///                   are split
  /// @note Cost: O(n log n).
  template <class Summarize>
  BoxTree(std::span<const Eigen::AlignedBox3d> boxes, std::span<const Eigen::Vector3d> centers,
          Summarize summarize)
      : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.emplace_back();
    nodes_[0].count = static_cast<Index>(boxes.size());
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const std::span<Index> members = std::span(order_).subspan(
          static_cast<std::size_t>(nodes_[n].first), static_cast<std::size_t>(nodes_[n].count));
      for (const Index i : members) {
        nodes_[n].box.extend(boxes[i]);
      }
      summarize(std::span<const Index>(members));
      if (nodes_[n].count <= kLeafSize) {
        continue;
      }
      Eigen::Index axis = 0;
      nodes_[n].box.sizes().maxCoeff(&axis);
      const Index half = nodes_[n].count / 2;
      std::nth_element(members.begin(), members.begin() + half, members.end(),
                       [&](Index a, Index b) { return centers[a][axis] < centers[b][axis]; });
      Node left, right;
      left.first = nodes_[n].first;
      left.count = half;
      right.first = left.first + half;
      right.count = nodes_[n].count - half;
      nodes_[n].left = static_cast<Index>(nodes_.size());
      nodes_.push_back(left);
      nodes_.push_back(right);
    }
  }

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// Ids of the boxes, leaf by leaf.
  [[nodiscard]] const std::vector<Index>& order() const { return order_; }

  /// Calls visit(a, b) once for every two boxes that lie in one leaf or in two whose boxes overlap,
  /// always in the same order, until it returns false.
  template <class Visit>
  void visit_near_pairs(Visit visit) const {
    std::vector<std::pair<Index, Index>> stack{{0, 0}};
    while (!stack.empty()) {
      const auto [a, b] = stack.back();
      stack.pop_back();
      const Node& first = nodes_[a];
      const Node& second = nodes_[b];
      const bool first_is_leaf = first.left == kInvalidIndex;
      const bool second_is_leaf = second.left == kInvalidIndex;
      if (a != b && !first.box.intersects(second.box)) {
        continue;
      }
      if (first_is_leaf && second_is_leaf) {
        for (Index i = first.first; i < first.first + first.count; ++i) {
          for (Index j = a == b ? i + 1 : second.first; j < second.first + second.count; ++j) {
            if (!visit(order_[i], order_[j])) {
              return;
            }
          }
        }
      } else if (a == b) {
        stack.emplace_back(first.left, first.left);
        stack.emplace_back(first.left + 1, first.left + 1);
        stack.emplace_back(first.left, first.left + 1);
      } else if (second_is_leaf || (!first_is_leaf && first.count >= second.count)) {
        stack.emplace_back(first.left, b);
        stack.emplace_back(first.left + 1, b);
      } else {
        stack.emplace_back(a, second.left);
        stack.emplace_back(a, second.left + 1);
      }
    }
  }

 private:
  std::vector<Node> nodes_;
  std::vector<Index> order_;
};

}  // namespace pbdsurg
