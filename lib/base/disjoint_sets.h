// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Elements that belong together, by pairs that do.

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace pbdsurg {

/// Sets that only ever grow together; the smallest member stands for its set.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }

  /// The same for all elements of a set: the smallest of them.
  [[nodiscard]] std::size_t root(std::size_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];  // path halving
      i = parents_[i];
    }
    return i;
  }

  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parents_;
};

}  // namespace pbdsurg
