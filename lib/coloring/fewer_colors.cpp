// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/fewer_colors.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"

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

class ColorWalk {
 public:
  ColorWalk(const IndexLists& conflicts, std::uint64_t seed)
      : conflicts_(conflicts), seed_(seed), effort_(effort_for(conflicts)) {}

  // Whether it could; else nothing has changed.
  bool empty_smallest(Coloring& coloring) {
    Coloring tried = coloring;
    take_smallest(tried);
    users_.resize(static_cast<std::size_t>(tried.color_count));
    while (!uncolored_.empty() && effort_ > 0) {
      move(tried.color_of);
    }
    if (!uncolored_.empty()) {
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

  void move(std::vector<Index>& color_of) {
    const std::uint64_t bits = random_bits(seed_, draws_++);
    Index& drawn = uncolored_[((bits >> 32) * uncolored_.size()) >> 32];
    const Index c = std::exchange(drawn, uncolored_.back());
    uncolored_.pop_back();
    std::ranges::fill(users_, 0);
    for (const Index neighbor : conflicts_[c]) {
      if (color_of[neighbor] != kInvalidIndex) {
        ++users_[color_of[neighbor]];
      }
    }
    effort_ -= static_cast<std::int64_t>(conflicts_[c].size()) + 1;
    const Index color = draw_color(bits);
    color_of[c] = color;
    for (const Index neighbor : conflicts_[c]) {
      if (users_[color] > 0 && color_of[neighbor] == color) {
        color_of[neighbor] = kInvalidIndex;
        uncolored_.push_back(neighbor);
      }
    }
  }

  [[nodiscard]] Index draw_color(std::uint64_t bits) const {
    const auto weight = [](Index users) {
      constexpr Index kMost = 8;
      return std::uint64_t{1} << (3 * std::max(kMost - users, 0));
    };
    std::uint64_t sum = 0;
    for (const Index users : users_) {
      sum += weight(users);
    }
    std::uint64_t left = bits % sum;
    Index color = 0;
    while (left >= weight(users_[color])) {
      left -= weight(users_[color++]);
    }
    return color;
  }

  const IndexLists& conflicts_;
  std::uint64_t seed_;
  std::uint64_t draws_ = 0;
  std::int64_t effort_;
  std::vector<Index> uncolored_;
  std::vector<Index> users_;  // [color] of the neighbours of who moves
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
  ColorWalk walk(conflicts, seed);
  while (may_have_fewer() && walk.empty_smallest(coloring)) {
  }
}

}  // namespace pbdsurg
