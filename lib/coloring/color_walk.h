// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A random walk of partial colourings, of a whole mesh or of what is new in it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Partial colourings as PartialCol has (Bloechliger, Zufferey 2008, "A graph coloring heuristic
/// using partial solutions and a reactive tabu scheme"), with chance in place of a tabu list.
///
/// One of those without a colour is drawn and takes any; neighbours of that colour lose it and are
/// without one in turn. A colour is eight times less likely for each neighbour that would lose it:
/// with four times the walk spreads, with twelve it gets stuck.
class ColorWalk {
 public:
  /// @param effort  how many neighbours it may look at, in all runs
  ColorWalk(std::uint64_t seed, std::int64_t effort) : seed_(seed), effort_(effort) {}

  /// @param color_of    below color_count, or kInvalidIndex for those in `uncolored`
  /// @param uncolored   in any order; those that are left
  /// @param neighbors_of  gives a span of those that need another colour than one; may append to
  ///                    color_of
  /// @return whether all have a colour; else the effort is spent
  template <class NeighborsOf>
  bool run(std::vector<Index>& color_of, std::vector<Index>& uncolored, Index color_count,
           const NeighborsOf& neighbors_of) {
    users_.resize(static_cast<std::size_t>(color_count));
    while (!uncolored.empty() && effort_ > 0) {
      move(color_of, uncolored, neighbors_of);
    }
    return uncolored.empty();
  }

 private:
  template <class NeighborsOf>
  void move(std::vector<Index>& color_of, std::vector<Index>& uncolored,
            const NeighborsOf& neighbors_of) {
    const std::uint64_t bits = random_bits(seed_, draws_++);
    Index& drawn = uncolored[((bits >> 32) * uncolored.size()) >> 32];
    const Index c = std::exchange(drawn, uncolored.back());
    uncolored.pop_back();
    const std::span<const Index> neighbors = neighbors_of(c);
    std::ranges::fill(users_, 0);
    for (const Index neighbor : neighbors) {
      if (color_of[neighbor] != kInvalidIndex) {
        ++users_[color_of[neighbor]];
      }
    }
    effort_ -= static_cast<std::int64_t>(neighbors.size()) + 1;
    const Index color = draw_color(bits);
    color_of[c] = color;
    for (const Index neighbor : neighbors) {
      if (users_[color] > 0 && color_of[neighbor] == color) {
        color_of[neighbor] = kInvalidIndex;
        uncolored.push_back(neighbor);
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

  std::uint64_t seed_;
  std::uint64_t draws_ = 0;
  std::int64_t effort_;
  std::vector<Index> users_;  // [color] of the neighbours of who moves
};

}  // namespace pbdsurg
