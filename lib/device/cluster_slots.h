// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which vertex lies in which slot of each block's shared memory.

#include <cstdint>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg::cuda {

/// Vertices at home in a block have its first slots, without a gap, for these are loaded before the
/// sweeps and stored after them. A vertex that others take the place of moves to another slot.
class ClusterSlots {
 public:
  explicit ClusterSlots(int block_count) : blocks_(static_cast<std::size_t>(block_count)) {}

  /// Vertices beyond have no slot, before and after.
  void set_place_count(Index place_count);

  /// @return  or kInvalidIndex if it has none there
  [[nodiscard]] Index slot(Index block, Index place) const { return slots_[at(block, place)]; }
  /// @return  block, or kInvalidIndex
  [[nodiscard]] Index home(Index place) const { return homes_[place]; }
  [[nodiscard]] Index home_count(Index block) const { return blocks_[block].home_count; }
  /// [slot] kInvalidIndex where it is free
  [[nodiscard]] const std::vector<Index>& places(Index block) const {
    return blocks_[block].places;
  }

  /// Slots that no vertex has, of those that there are.
  [[nodiscard]] Index free_count(Index block) const {
    return static_cast<Index>(blocks_[block].free.size());
  }

  /// Gives a vertex a slot of the block, unless it has one.
  void acquire(Index block, Index place);
  /// Takes the slots of a vertex that is not at home there.
  void release(Index block, Index place);
  /// Makes a vertex at home where it has a slot; it has no other home.
  void settle(Index block, Index place);
  /// Its slot there is then one like others.
  void unsettle(Index place);

  /// Slots with another vertex, or another home, since this was cleared: block and slot.
  std::vector<std::pair<Index, Index>> changed;
  /// Vertices in other slots since this was cleared.
  std::vector<Index> moved;

 private:
  struct Block {
    std::vector<Index> places;
    std::vector<Index> free;  // slots
    Index home_count = 0;
  };

  [[nodiscard]] std::size_t at(Index block, Index place) const {
    return static_cast<std::size_t>(place) * blocks_.size() + static_cast<std::size_t>(block);
  }
  void swap(Index block, Index a, Index b);

  std::vector<Block> blocks_;
  std::vector<Index> slots_;  // [place][block]
  std::vector<Index> homes_;  // [place] block
};

}  // namespace pbdsurg::cuda
