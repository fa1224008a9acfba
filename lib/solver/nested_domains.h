// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Halves of halves of the vertices, for a nested plan.

#include <Eigen/Core>
#include <bit>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg {

/// Vertices divided by recursive bisection: 2^(level_count - 1) leaves, and level by level the
/// domains that two of the level below make, up to one that holds all. Domains of one level share
/// no vertex. Made by default, all vertices are one domain.
class NestedDomains {
 public:
  NestedDomains() = default;

  /// Leaves of 1500 to 3000 vertices, whose positions stay in a first-level cache.
  /// @param positions  [vertex_count] m, finite
  explicit NestedDomains(std::span<const Eigen::Vector3d> positions);

  [[nodiscard]] Index level_count() const noexcept { return level_count_; }
  [[nodiscard]] Index domain_count(Index level) const noexcept {
    return Index{1} << (level_count_ - 1 - level);
  }

  /// A domain within a level; leaves are level 0.
  struct Place {
    Index level = 0;
    Index domain = 0;
  };

  /// The smallest domain that holds all of some vertices.
  template <class Vertices>
  [[nodiscard]] Place place_of(const Vertices& vertices) const {
    if (leaf_of_vertex_.empty()) {
      return {};
    }
    const Index leaf = leaf_of_vertex_[vertices[0]];
    unsigned differing = 0;
    for (const Index v : vertices) {
      differing |= static_cast<unsigned>(leaf ^ leaf_of_vertex_[v]);
    }
    const auto level = static_cast<Index>(std::bit_width(differing));
    return {level, leaf >> level};
  }

 private:
  Index level_count_ = 1;
  std::vector<Index> leaf_of_vertex_;  // [vertex_count], empty for one domain
};

}  // namespace pbdsurg
