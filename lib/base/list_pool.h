// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Many short lists that grow and shrink, in one array.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Lists in blocks of 4, 8, 16, ... entries. Blocks that a list has left are given to others, so
/// that once all have grown to what they need nothing is allocated any more.
class ListPool {
 public:
  void resize(std::size_t list_count) { lists_.resize(list_count); }

  [[nodiscard]] std::span<const Index> operator[](Index list) const noexcept {
    return {entries_.data() + lists_[list].begin, static_cast<std::size_t>(lists_[list].size)};
  }

  void reserve(Index list, std::size_t capacity) {
    if (capacity > capacity_of(lists_[list].block)) {
      move_to_block_for(lists_[list], capacity);
    }
  }

  /// Makes room for more lists, and for entries of lists that have to grow.
  void reserve_room(std::size_t lists, std::size_t entries) {
    lists_.reserve(lists_.size() + lists);
    entries_.reserve(entries_.size() + entries);
    for (std::size_t block = 0; block < free_.size() && (std::size_t{4} << block) <= entries;
         ++block) {
      free_[block].reserve(free_[block].size() + entries / (std::size_t{4} << block));
    }
  }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t bytes = lists_.capacity() * sizeof(List) + entries_.capacity() * sizeof(Index);
    for (const auto& begins : free_) {
      bytes += begins.capacity() * sizeof(std::size_t);
    }
    return bytes;
  }

  /// @param values  not of this pool
  void assign(Index list, std::span<const Index> values) {
    clear(list);
    reserve(list, values.size());
    std::copy(values.begin(), values.end(), first(list));
    lists_[list].size = static_cast<Index>(values.size());
  }

  void insert(Index list, Index position, Index value) {
    const Index size = lists_[list].size;
    reserve(list, static_cast<std::size_t>(size) + 1);
    const auto begin = first(list);
    std::copy_backward(begin + position, begin + size, begin + size + 1);
    begin[position] = value;
    ++lists_[list].size;
  }

  void erase(Index list, Index position) {
    const auto begin = first(list);
    std::copy(begin + position + 1, begin + lists_[list].size, begin + position);
    --lists_[list].size;
  }

  /// Empties a list and gives its block away.
  void clear(Index list) {
    give_away(lists_[list]);
    lists_[list] = {};
  }

 private:
  static constexpr int kNoBlock = -1;

  struct List {
    std::size_t begin = 0;
    Index size = 0;
    int block = kNoBlock;  // of 4 << block entries
  };

  static std::size_t capacity_of(int block) {
    return block == kNoBlock ? 0 : std::size_t{4} << block;
  }

  std::vector<Index>::iterator first(Index list) {
    return entries_.begin() + static_cast<std::ptrdiff_t>(lists_[list].begin);
  }

  void move_to_block_for(List& list, std::size_t capacity) {
    int block = 0;
    while (capacity_of(block) < capacity) {
      ++block;
    }
    std::size_t begin = entries_.size();
    if (free_[block].empty()) {
      entries_.resize(begin + capacity_of(block));
    } else {
      begin = free_[block].back();
      free_[block].pop_back();
    }
    std::copy_n(entries_.data() + list.begin, list.size, entries_.data() + begin);
    give_away(list);
    list = {begin, list.size, block};
  }

  void give_away(const List& list) {
    if (list.block != kNoBlock) {
      free_[list.block].push_back(list.begin);
    }
  }

  std::vector<List> lists_;
  std::vector<Index> entries_;
  std::array<std::vector<std::size_t>, 30>
      free_;  // [block] begins; a list has at most 2^31 entries
};

}  // namespace pbdsurg
