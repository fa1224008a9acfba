// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Halves of halves of the vertices: the order in which their state lies, and the domains of a
/// nested plan.

#include <Eigen/Core>
#include <bit>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Vertices in an order in which each half, quarter, eighth and so on is compact.
/// @param positions  [vertex_count] m, finite
/// @return           [vertex_count] the place of each vertex
[[nodiscard]] std::vector<Index> order_vertices(std::span<const Eigen::Vector3d> positions);

/// Places divided in halves again and again: 2^(level_count - 1) leaves, and level by level the
/// domains that two of the level below make, up to one that holds all. Domains of one level share
/// no place. Made by default, all is one domain.
class NestedDomains {
 public:
  NestedDomains() = default;

  /// Leaves of 3000 to 6000 places. Smaller ones would fit a first-level cache, but leave more of
  /// the work to upper levels and to registers that are not full.
  explicit NestedDomains(Index place_count) noexcept;

  [[nodiscard]] Index level_count() const noexcept { return level_count_; }
  [[nodiscard]] Index domain_count(Index level) const noexcept {
    return Index{1} << (level_count_ - 1 - level);
  }

  /// A domain within a level; leaves are level 0.
  struct Domain {
    Index level;
    Index index;
  };

  /// The smallest domain that holds all of some places.
  template <class Places>
  [[nodiscard]] Domain domain_of(const Places& places) const noexcept {
    const Index leaf = leaf_of(places[0]);
    unsigned differing = 0;
    for (const Index place : places) {
      differing |= static_cast<unsigned>(leaf ^ leaf_of(place));
    }
    const auto level = static_cast<Index>(std::bit_width(differing));
    return {level, leaf >> level};
  }

 private:
  // The first leaves have one place more.
  [[nodiscard]] Index leaf_of(Index place) const noexcept {
    const Index in_larger = larger_leaves_ * (leaf_size_ + 1);
    return place < in_larger ? place / (leaf_size_ + 1)
                             : larger_leaves_ + (place - in_larger) / leaf_size_;
  }

  Index level_count_ = 1;
  Index leaf_size_ = std::numeric_limits<Index>::max() - 1;  // it has a successor
  Index larger_leaves_ = 0;
};

}  // namespace pbdsurg
