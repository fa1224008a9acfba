// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Parts of one array, for what grows and shrinks.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <vector>

namespace pbdsurg::cuda {

/// Hands out ranges of an array; what is given back goes to others.
class RangePool {
 public:
  struct Range {
    std::size_t first = 0;
    std::size_t size = 0;
  };

  explicit RangePool(std::size_t size) : free_{{0, size}} {}

  /// The first range that is free, of the size wanted; where there is none, the largest one.
  /// @return  nothing if that is smaller than `least`
  [[nodiscard]] std::optional<Range> take(std::size_t least, std::size_t wanted) {
    auto found = std::ranges::find_if(free_, [&](const Range& r) { return r.size >= wanted; });
    if (found == free_.end()) {
      found = std::ranges::max_element(free_, {}, &Range::size);
    }
    if (found == free_.end() || found->size < least) {
      return std::nullopt;
    }
    const Range taken{found->first, std::min(found->size, wanted)};
    found->first += taken.size;
    found->size -= taken.size;
    if (found->size == 0) {
      free_.erase(found);
    }
    return taken;
  }

  void give_back(const Range& range) {
    if (range.size == 0) {
      return;
    }
    auto next = std::ranges::upper_bound(free_, range.first, {}, &Range::first);
    if (next != free_.begin() && end_of(*std::prev(next)) == range.first) {
      std::prev(next)->size += range.size;
    } else {
      next = std::next(free_.insert(next, range));
    }
    const auto now = std::prev(next);
    if (next != free_.end() && end_of(*now) == next->first) {
      now->size += next->size;
      free_.erase(next);
    }
  }

 private:
  static std::size_t end_of(const Range& range) { return range.first + range.size; }

  std::vector<Range> free_;  // ascending; none touches the next
};

}  // namespace pbdsurg::cuda
