// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints of one type, grouped by what is projected together, with stable ids.

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg {

/// What one projection reads, contiguous so that it costs one or two cache lines.
template <std::size_t kArity>
struct ConstraintRecord {
  std::array<Index, kArity> vertices;
  float rest;       ///< m or m^3
  float stiffness;  ///< fraction, or compliance in m/N or m^5/N
};

/// A group is a colour, or constraints that another rule keeps together. An id keeps its meaning
/// while its slot moves. A constraint leaves a group by a swap with its last, in constant time;
/// colours stay valid.
template <std::size_t kArity>
class ConstraintSlots {
 public:
  using Record = ConstraintRecord<kArity>;

  ConstraintSlots() = default;

  /// @param records   [id_count]
  /// @param group_of  [id_count] kInvalidIndex where an id stands for no constraint
  ConstraintSlots(std::span<const Record> records, std::span<const Index> group_of,
                  Index group_count)
      : groups_(static_cast<std::size_t>(group_count)),
        group_of_id_(records.size(), kInvalidIndex),
        slot_of_id_(records.size(), kInvalidIndex) {
    for (std::size_t id = 0; id < records.size(); ++id) {
      if (group_of[id] != kInvalidIndex) {
        append(static_cast<Index>(id), group_of[id], records[id], 0);
      }
    }
  }

  [[nodiscard]] Index group_count() const noexcept { return static_cast<Index>(groups_.size()); }
  [[nodiscard]] std::span<const Record> records(Index group) const noexcept {
    return groups_[group].records;
  }
  [[nodiscard]] std::span<float> multipliers(Index group) noexcept {
    return groups_[group].multipliers;
  }
  void reset_multipliers() noexcept {
    for (Group& group : groups_) {
      std::fill(group.multipliers.begin(), group.multipliers.end(), 0.0F);
    }
  }

  /// Of a constraint: kInvalidIndex if there is none of that id, or none any more.
  [[nodiscard]] Index group_of(Index id) const noexcept { return group_of_id_[id]; }
  [[nodiscard]] bool is_alive(Index id) const noexcept { return group_of(id) != kInvalidIndex; }
  [[nodiscard]] const Record& record(Index id) const noexcept {
    return groups_[group_of(id)].records[slot_of_id_[id]];
  }
  void set_rest(Index id, float rest) noexcept {
    groups_[group_of(id)].records[slot_of_id_[id]].rest = rest;
  }

  void remove(Index id) noexcept {
    Group& group = groups_[group_of(id)];
    const Index slot = slot_of_id_[id];
    const Index last = group.ids.back();
    group.records[slot] = group.records.back();
    group.multipliers[slot] = group.multipliers.back();
    group.ids[slot] = last;
    group.records.pop_back();
    group.multipliers.pop_back();
    group.ids.pop_back();
    slot_of_id_[last] = slot;
    group_of_id_[id] = kInvalidIndex;
  }

  void move(Index id, Index group) {
    const Record record = this->record(id);
    const float multiplier = groups_[group_of(id)].multipliers[slot_of_id_[id]];
    remove(id);
    append(id, group, record, multiplier);
  }

 private:
  struct Group {
    std::vector<Record> records;     // [slot]
    std::vector<float> multipliers;  // [slot] kg m or kg/m
    std::vector<Index> ids;          // [slot]
  };

  void append(Index id, Index group_index, const Record& record, float multiplier) {
    Group& group = groups_[group_index];
    group_of_id_[id] = group_index;
    slot_of_id_[id] = static_cast<Index>(group.ids.size());
    group.records.push_back(record);
    group.multipliers.push_back(multiplier);
    group.ids.push_back(id);
  }

  std::vector<Group> groups_;
  std::vector<Index> group_of_id_;  // [id] kInvalidIndex once removed
  std::vector<Index> slot_of_id_;   // [id] within the group
};

}  // namespace pbdsurg
