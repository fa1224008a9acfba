// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Ids that must be refused.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "pbdsurg/base/types.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// Some out of [0, count): just beyond either end, and as far as ids go.
[[nodiscard]] inline std::array<Index, 4> bad_ids(Index count) {
  return {-1, count, std::numeric_limits<Index>::min(), std::numeric_limits<Index>::max()};
}

/// Out of [0, count).
[[nodiscard]] inline Index bad_id(Index count, Choices& choices) {
  switch (choices.below(3)) {
    case 0:
      return count + choices.below(3);
    case 1:
      return -1 - choices.below(3);
    default:
      return std::numeric_limits<Index>::max() - choices.below(2);
  }
}

/// Puts an id that is out of range, or dead, or twice in the list, in some place of it.
/// @param count  of ids that there ever were
/// @param live   ascending
/// @param make   Entry(Index id)
template <class Entry, class MakeEntry>
void spoil_ids(Choices& choices, std::vector<Entry>& entries, std::size_t count,
               const std::vector<Index>& live, MakeEntry make) {
  const auto insert = [&](const Entry& bad) {
    const Index place = choices.below(static_cast<Index>(entries.size()) + 1);
    entries.insert(entries.begin() + place, bad);
  };
  const auto dead =
      find_all(count, [&](Index id) { return !std::ranges::binary_search(live, id); });
  switch (choices.below(3)) {
    case 0:
      if (!dead.empty()) {
        insert(make(choices.one_of(dead)));
        return;
      }
      [[fallthrough]];
    case 1:
      if (!live.empty()) {
        entries.push_back(make(choices.one_of(live)));
        insert(entries.back());
        return;
      }
      [[fallthrough]];
    default:
      insert(make(bad_id(static_cast<Index>(count), choices)));
  }
}

}  // namespace pbdsurg::testing
