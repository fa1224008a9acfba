// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/fewer_colors.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "lib/coloring/color_walk.h"

namespace pbdsurg {
namespace {

// How often as many neighbours are looked at as there are.
constexpr std::int64_t kPatience = 100;

std::int64_t effort_for(const IndexLists& conflicts) {
  return kPatience * static_cast<std::int64_t>(conflicts.entries.size());
}

// Looks for odd rings around two that conflict.
class RingSearch {
 public:
  explicit RingSearch(const IndexLists& conflicts)
      : conflicts_(conflicts),
        ring_of_(static_cast<std::size_t>(conflicts.list_count()), 0),
        side_(ring_of_.size(), 0),
        neighbor_of_(ring_of_.size(), kInvalidIndex),
        effort_(effort_for(conflicts)) {}

  bool run() {
    for (Index c = 0; c < conflicts_.list_count() && effort_ > 0; ++c) {
      for (const Index neighbor : look_at(c)) {
        neighbor_of_[neighbor] = c;
      }
      for (const Index other : conflicts_[c]) {
        // each pair once, by the one with fewer neighbours
        if (std::pair(conflicts_[other].size(), other) < std::pair(conflicts_[c].size(), c) &&
            has_odd_ring(c, other)) {
          return true;
        }
      }
    }
    return false;
  }

 private:
  std::span<const Index> look_at(Index constraint) {
    const std::span<const Index> neighbors = conflicts_[constraint];
    effort_ -= static_cast<std::int64_t>(neighbors.size());
    return neighbors;
  }

  // Whether two sides are too few for what both conflict with.
  bool has_odd_ring(Index c, Index other) {
    ++rings_;
    common_.clear();
    for (const Index neighbor : look_at(other)) {
      if (neighbor_of_[neighbor] == c) {
        common_.push_back(neighbor);
        ring_of_[neighbor] = rings_;
        side_[neighbor] = 0;
      }
    }
    for (const Index first : common_) {
      if (side_[first] == 0 && !has_two_sides(first)) {
        return true;
      }
    }
    return false;
  }

  bool has_two_sides(Index first) {
    side_[first] = 1;
    reached_.assign(1, first);
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      const Index here = reached_[i];
      for (const Index next : look_at(here)) {
        if (ring_of_[next] != rings_) {
          continue;
        }
        if (side_[next] == side_[here]) {
          return false;
        }
        if (side_[next] == 0) {
          side_[next] = -side_[here];
          reached_.push_back(next);
        }
      }
    }
    return true;
  }

  const IndexLists& conflicts_;
  std::int64_t rings_ = 0;
  std::vector<std::int64_t> ring_of_;  // [constraint] the last ring that it was of
  std::vector<int> side_;              // [constraint] 1 or -1; 0 before it is reached
  std::vector<Index> neighbor_of_;     // [constraint] the last for which it was marked
  std::vector<Index> common_, reached_;
  std::int64_t effort_;
};

class ColorSearch {
 public:
  ColorSearch(const IndexLists& conflicts, std::uint64_t seed)
      : conflicts_(conflicts), walk_(seed, effort_for(conflicts)) {}

  // Whether it could; else nothing has changed.
  bool empty_smallest(Coloring& coloring) {
    Coloring tried = coloring;
    take_smallest(tried);
    if (!walk_.run(tried.color_of, uncolored_, tried.color_count,
                   [&](Index c) { return conflicts_[c]; })) {
      return false;
    }
    coloring = std::move(tried);
    return true;
  }

 private:
  // The last gets its number.
  void take_smallest(Coloring& coloring) {
    const std::vector<Index> sizes = color_sizes(coloring);
    const auto smallest = static_cast<Index>(std::ranges::min_element(sizes) - sizes.begin());
    const Index last = --coloring.color_count;
    uncolored_.clear();
    for (Index c = 0; c < static_cast<Index>(coloring.color_of.size()); ++c) {
      Index& color = coloring.color_of[c];
      if (color == smallest) {
        color = kInvalidIndex;
        uncolored_.push_back(c);
      } else if (color == last) {
        color = smallest;
      }
    }
  }

  const IndexLists& conflicts_;
  ColorWalk walk_;
  std::vector<Index> uncolored_;
};

}  // namespace

IndexLists find_conflicts(const ConstraintVertices& constraints) {
  const IndexLists at_vertex = find_vertex_constraints(constraints);
  const Index count = constraints.constraint_count();
  IndexLists conflicts;
  std::vector<Index> found_by(static_cast<std::size_t>(count), kInvalidIndex);
  for (Index c = 0; c < count; ++c) {
    found_by[c] = c;
    for (const Index v : constraints[c]) {
      for (const Index other : at_vertex[v]) {
        if (found_by[other] != c) {
          found_by[other] = c;
          conflicts.entries.push_back(other);
        }
      }
    }
    conflicts.offsets.push_back(static_cast<Index>(conflicts.entries.size()));
  }
  return conflicts;
}

bool has_odd_ring(const IndexLists& conflicts) {
  return RingSearch(conflicts).run();
}

void find_fewer_colors(Coloring& coloring, const ConstraintVertices& constraints,
                       std::uint64_t seed) {
  constexpr Index kColorsAtOddRing = 5;
  const Index bound = std::max(clique_bound(constraints), Index{1});
  if (coloring.color_count <= bound) {
    return;
  }
  const IndexLists conflicts = find_conflicts(constraints);
  const auto may_have_fewer = [&] {
    return coloring.color_count > bound &&
           (coloring.color_count != kColorsAtOddRing || !has_odd_ring(conflicts));
  };
  ColorSearch search(conflicts, seed);
  while (may_have_fewer() && search.empty_smallest(coloring)) {
  }
}

}  // namespace pbdsurg
