// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/local_walk.h"

#include <algorithm>

#include "lib/coloring/color_walk.h"

namespace pbdsurg {

bool LocalWalk::run(std::span<const Index> uncolored, std::span<const Index> colors,
                    const std::vector<Index>& color_of, const ConflictsOf& conflicts_of,
                    std::int64_t effort) {
  constexpr std::uint64_t kSeed = 0;
  changes_.clear();
  if (colors.empty()) {
    return uncolored.empty();
  }
  index_of_.resize(color_of.size(), kInvalidIndex);
  const auto number_of = [&](Index constraint) {  // among the colours
    const auto found = std::ranges::find(colors, color_of[constraint]);
    return found == colors.end() ? kInvalidIndex : static_cast<Index>(found - colors.begin());
  };
  std::vector<Index> numbers, left;  // [reached]; those without one
  const auto add_reached = [&] {
    while (numbers.size() < reached_.size()) {
      numbers.push_back(number_of(reached_[numbers.size()]));
    }
  };
  for (const Index constraint : uncolored) {
    left.push_back(index_of(constraint));
  }
  add_reached();
  for (const Index i : left) {
    numbers[i] = kInvalidIndex;
  }
  const auto find_list = [&](Index i) {
    List& list = lists_[i];
    if (!list.is_known) {
      const std::span<const Index> found = conflicts_of(reached_[i]);
      list = {conflicts_.size(), found.size(), true};
      for (const Index constraint : found) {
        conflicts_.push_back(index_of(constraint));
      }
      add_reached();
    }
    return std::span<const Index>(conflicts_).subspan(lists_[i].first, lists_[i].count);
  };
  ColorWalk walk(kSeed, effort);
  if (!walk.run(numbers, left, static_cast<Index>(colors.size()), find_list)) {
    return false;
  }
  for (std::size_t i = 0; i < reached_.size(); ++i) {
    if (numbers[i] != number_of(reached_[i])) {
      changes_.push_back({reached_[i], colors[numbers[i]]});
    }
  }
  return true;
}

Index LocalWalk::index_of(Index constraint) {
  Index& index = index_of_[constraint];
  if (index == kInvalidIndex) {
    index = static_cast<Index>(reached_.size());
    reached_.push_back(constraint);
    lists_.emplace_back();
  }
  return index;
}

void LocalWalk::forget_conflicts() noexcept {
  for (const Index constraint : reached_) {
    index_of_[constraint] = kInvalidIndex;
  }
  reached_.clear();
  lists_.clear();
  conflicts_.clear();
}

}  // namespace pbdsurg
