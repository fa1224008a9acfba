// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which distance constraint is which edge or link.

#include <cstddef>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// The edges that a scene starts with come first, then its links, then what edits add, as it comes.
class DistanceIds {
 public:
  DistanceIds() = default;
  DistanceIds(Index edge_count, Index link_count)
      : first_edges_(edge_count), first_links_(link_count) {}

  [[nodiscard]] Index of_edge(Index edge) const noexcept {
    return edge < first_edges_ ? edge : later_edges_[edge - first_edges_];
  }
  [[nodiscard]] Index of_link(Index link) const noexcept {
    return link < first_links_ ? first_edges_ + link : later_links_[link - first_links_];
  }

  /// kInvalidIndex for that of a link.
  [[nodiscard]] Index edge_of(Index distance) const noexcept {
    if (distance < first_edges_) {
      return distance;
    }
    const Index later = distance - first_edges_ - first_links_;
    return later < 0 ? kInvalidIndex : edges_of_later_[later];
  }

  [[nodiscard]] Index count() const noexcept {
    return first_edges_ + first_links_ + static_cast<Index>(edges_of_later_.size());
  }

  /// That of the edge, or the link, that follows those there are.
  Index add_edge() {
    later_edges_.push_back(count());
    edges_of_later_.push_back(first_edges_ + static_cast<Index>(later_edges_.size()) - 1);
    return later_edges_.back();
  }
  Index add_link() {
    later_links_.push_back(count());
    edges_of_later_.push_back(kInvalidIndex);
    return later_links_.back();
  }

  /// Forgets those added last, down to as many.
  void shrink(std::size_t edge_count, std::size_t link_count) {
    later_edges_.resize(edge_count - static_cast<std::size_t>(first_edges_));
    later_links_.resize(link_count - static_cast<std::size_t>(first_links_));
    edges_of_later_.resize(later_edges_.size() + later_links_.size());
  }

  /// Makes room for more.
  void reserve(std::size_t edges, std::size_t links) {
    later_edges_.reserve(later_edges_.size() + edges);
    later_links_.reserve(later_links_.size() + links);
    edges_of_later_.reserve(edges_of_later_.size() + edges + links);
  }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return (later_edges_.capacity() + later_links_.capacity() + edges_of_later_.capacity()) *
           sizeof(Index);
  }

 private:
  Index first_edges_ = 0, first_links_ = 0;
  std::vector<Index> later_edges_, later_links_;  // distances
  std::vector<Index> edges_of_later_;             // [distance, after the first]
};

}  // namespace pbdsurg
