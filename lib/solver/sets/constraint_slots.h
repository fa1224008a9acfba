// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints of one type, grouped by what is projected together, with stable ids.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"

#include "lib/solver/sets/constraint_block.h"

namespace pbdsurg {

/// One constraint, taken out of its block.
template <class Constraint>
struct ConstraintRecord {
  std::array<Index, Constraint::kVertexCount> places;  ///< of its vertices, see SolverData
  std::array<float, Constraint::kParameterCount> parameters;
};

/// A group is a colour, or constraints that another rule keeps together. An id keeps its meaning
/// while its slot moves. A constraint leaves a group by a swap with its last, in constant time;
/// colours stay valid. What happens to constraints is kept in mind, and can be taken back.
template <class Constraint>
class ConstraintSlots {
 public:
  using Record = ConstraintRecord<Constraint>;
  using Block = ConstraintBlock<Constraint>;

  ConstraintSlots() = default;

  /// @param records   [id_count]
  /// @param group_of  [id_count] kInvalidIndex where an id stands for no constraint
  ConstraintSlots(std::span<const Record> records, std::span<const Index> group_of,
                  Index group_count)
      : groups_(static_cast<std::size_t>(group_count)) {
    // near constraints near each other, so that parts of a group touch different vertices
    std::vector<Index> order;
    for (std::size_t id = 0; id < records.size(); ++id) {
      if (group_of[id] != kInvalidIndex) {
        order.push_back(static_cast<Index>(id));
      }
    }
    const auto first_place = [&](Index id) { return std::ranges::min(records[id].places); };
    locations_.resize(order.empty() ? 0 : static_cast<std::size_t>(order.back()) + 1);
    std::ranges::stable_sort(order, {}, first_place);
    for (const Index id : order) {
      append(id, group_of[id], records[id]);
    }
    for (Group& group : groups_) {
      group.blocks.shrink_to_fit();
      group.ids.shrink_to_fit();
    }
  }

  [[nodiscard]] Index group_count() const noexcept { return static_cast<Index>(groups_.size()); }

  /// How many constraints a group holds: all blocks but its last are full.
  [[nodiscard]] Index size(Index group) const noexcept {
    return static_cast<Index>(groups_[group].ids.size());
  }
  [[nodiscard]] std::span<const Block> blocks(Index group) const noexcept {
    return groups_[group].blocks;
  }
  /// For how many there is room.
  [[nodiscard]] std::size_t block_capacity(Index group) const noexcept {
    return groups_[group].blocks.capacity();
  }

  /// The ids of a group's constraints, in the order of their slots.
  [[nodiscard]] std::span<const Index> ids(Index group) const noexcept {
    return groups_[group].ids;
  }

  /// Of a constraint: kInvalidIndex if there is none of that id, or none any more.
  [[nodiscard]] Index group_of(Index id) const noexcept {
    return id < static_cast<Index>(locations_.size()) ? locations_[id].group : kInvalidIndex;
  }
  [[nodiscard]] bool is_alive(Index id) const noexcept { return group_of(id) != kInvalidIndex; }

  /// Of a live constraint.
  [[nodiscard]] Record record(Index id) const noexcept {
    const auto [block, lane] = place_of(id);
    return get(groups_[group_of(id)].blocks[block], lane);
  }
  void set_parameter(Index id, typename Constraint::Parameter parameter, float value) {
    remember(id);
    const auto [block, lane] = place_of(id);
    Group& group = groups_[group_of(id)];
    group.blocks[block].parameters[parameter][lane] = value;
    fill_idle_lanes(group);
  }

  void set_places(Index id, const std::array<Index, Constraint::kVertexCount>& places) {
    Record changed = record(id);
    remember(id);
    changed.places = places;
    const auto [block, lane] = place_of(id);
    Group& group = groups_[group_of(id)];
    put(group.blocks[block], lane, changed);
    fill_idle_lanes(group);
  }

  /// Prefetches where a constraint is; once that is near, what remove() needs.
  void prefetch_location(Index id) const noexcept {
    if (id < static_cast<Index>(locations_.size())) {  // a kind that nobody uses has none
      __builtin_prefetch(&locations_[id]);
    }
  }
  void prefetch_removal(Index id) const noexcept {
    if (!is_alive(id)) {
      return;
    }
    const Group& group = groups_[group_of(id)];
    const auto [block, lane] = place_of(id);
    __builtin_prefetch(&group.ids[locations_[id].slot]);
    for (const Block* const part : {&group.blocks[block], &group.blocks.back()}) {
      for (const auto& corners : part->corners) {
        __builtin_prefetch(&corners[lane]);
      }
      for (const auto& values : part->parameters) {
        __builtin_prefetch(&values[lane]);
      }
    }
  }

  void remove(Index id) {
    remember(id);
    take_out(id);
  }

  /// Adds a constraint that there is not.
  void add(Index id, Index group, const Record& record) {
    remember(id);
    append(id, group, record);
  }

  /// Opens a group that follows the others, and is empty; or closes the last, which must be.
  void open_group() { groups_.emplace_back(); }
  void close_group() noexcept { groups_.pop_back(); }

  /// Makes room for ids, for as many constraints more in each of some groups, and for an edit that
  /// changes as many, or some thousands of them.
  void reserve(std::size_t ids, std::span<const Index> groups) {
    locations_.reserve(locations_.size() + ids);
    journal_.reserve(std::min(ids, kEntriesOfEdit));
    for (const Index g : groups) {
      Group& group = groups_[g];
      const std::size_t blocks = (group.ids.size() + ids) / kBlockLanes + 1;
      group.blocks.reserve(blocks);
      group.ids.reserve(group.ids.size() + ids);
    }
  }

  void move(Index id, Index group) {
    const Record moved = record(id);
    remove(id);
    remember(id);
    append(id, group, moved);
  }

  /// Whether a group was emptied, or is no longer empty, since this was asked before.
  [[nodiscard]] bool take_change_of_groups() noexcept {
    return std::exchange(groups_changed_, false);
  }

  /// Forgets what happened so far.
  void begin_edit() noexcept { journal_.clear(); }

  /// Takes back all that happened since begin_edit(), the last first, to the same slots.
  /// @param visit  void(Index id), for each constraint that is another now; some more than once
  template <class Visit>
  void undo(Visit visit) {
    for (; !journal_.empty(); journal_.pop_back()) {
      const Before& before = journal_.back();
      if (before.group == kInvalidIndex) {
        take_out(before.id);
      } else if (is_alive(before.id)) {
        const auto [block, lane] = place_of(before.id);
        Group& group = groups_[before.group];
        put(group.blocks[block], lane, before.record);
        fill_idle_lanes(group);
      } else {
        put_back(before);
      }
      visit(before.id);
    }
  }

  /// Bytes in use for constraints and their ids.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t bytes =
        locations_.capacity() * sizeof(Location) + journal_.capacity() * sizeof(Before);
    for (const Group& group : groups_) {
      bytes += group.blocks.capacity() * sizeof(Block) + group.ids.capacity() * sizeof(Index);
    }
    return bytes;
  }

 private:
  struct Group {
    std::vector<Block> blocks;
    std::vector<Index> ids;  // [slot]
  };
  struct Location {
    Index group = kInvalidIndex;  // once removed
    Index slot = kInvalidIndex;   // within the group
  };
  struct Place {
    Index block, lane;
  };
  // A constraint before a change.
  struct Before {
    Index id;
    Index group;  // kInvalidIndex if there was none
    Index slot;
    Record record;
  };

  [[nodiscard]] Place place_of(Index id) const noexcept {
    return {locations_[id].slot / kBlockLanes, locations_[id].slot % kBlockLanes};
  }

  static Record get(const Block& block, Index lane) noexcept {
    Record record;
    for (int k = 0; k < Constraint::kVertexCount; ++k) {
      record.places[k] = place_at(block.corners[k][lane]);
    }
    for (int p = 0; p < Constraint::kParameterCount; ++p) {
      record.parameters[p] = block.parameters[p][lane];
    }
    return record;
  }

  static void put(Block& block, Index lane, const Record& record) noexcept {
    for (int k = 0; k < Constraint::kVertexCount; ++k) {
      block.corners[k][lane] = offset_of(record.places[k]);
    }
    for (int p = 0; p < Constraint::kParameterCount; ++p) {
      block.parameters[p][lane] = record.parameters[p];
    }
  }

  // Registers are loaded and stored whole: idle lanes repeat the last in use, which is in the same
  // register whatever its width. So they do what it does, with the same result, and touch no vertex
  // that another thread may be moving.
  static void fill_idle_lanes(Group& group) noexcept {
    Block& block = group.blocks.back();
    const Index last = (static_cast<Index>(group.ids.size()) - 1) % kBlockLanes;
    const Record record = get(block, last);
    for (Index lane = last + 1; lane < kBlockLanes; ++lane) {
      put(block, lane, record);
    }
  }

  void remember(Index id) {
    if (is_alive(id)) {
      journal_.push_back({id, group_of(id), locations_[id].slot, record(id)});
    } else {
      journal_.push_back({id, kInvalidIndex, kInvalidIndex, {}});
    }
  }

  void take_out(Index id) noexcept {
    Group& group = groups_[group_of(id)];
    const auto [block, lane] = place_of(id);
    const Index last_slot = static_cast<Index>(group.ids.size()) - 1;
    const Index last_lane = last_slot % kBlockLanes;
    const Index last = group.ids.back();
    put(group.blocks[block], lane, get(group.blocks.back(), last_lane));
    group.ids[locations_[id].slot] = last;
    locations_[last].slot = locations_[id].slot;
    group.ids.pop_back();
    groups_changed_ = groups_changed_ || group.ids.empty();
    locations_[id] = {};
    if (last_lane == 0) {
      group.blocks.pop_back();
    } else {
      fill_idle_lanes(group);
    }
  }

  // The other way round than take_out(): what is in its slot goes to the end.
  void put_back(const Before& before) {
    Group& group = groups_[before.group];
    if (before.slot == static_cast<Index>(group.ids.size())) {
      append(before.id, before.group, before.record);
      return;
    }
    const Index other = group.ids[before.slot];
    append(other, before.group, record(other));
    group.ids[before.slot] = before.id;
    locations_[before.id] = {before.group, before.slot};
    const auto [block, lane] = place_of(before.id);
    put(group.blocks[block], lane, before.record);
  }

  void append(Index id, Index group_index, const Record& record) {
    Group& group = groups_[group_index];
    const Index slot = static_cast<Index>(group.ids.size());
    const Index lane = slot % kBlockLanes;
    if (lane == 0) {
      group.blocks.emplace_back();
    }
    put(group.blocks.back(), lane, record);
    group.ids.push_back(id);
    groups_changed_ = groups_changed_ || slot == 0;
    if (id >= static_cast<Index>(locations_.size())) {
      locations_.resize(static_cast<std::size_t>(id) + 1);
    }
    locations_[id] = {group_index, slot};
    fill_idle_lanes(group);
  }

  std::vector<Group> groups_;
  std::vector<Location> locations_;  // [id] up to the last that ever had a constraint
  std::vector<Before> journal_;
  bool groups_changed_ = false;
};

}  // namespace pbdsurg
