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

/// A group is a colour, or constraints that some other rule keeps apart. An id keeps its meaning
/// while its slot moves. Removing swaps with the last of the same group, so groups stay contiguous
/// and colours valid, in constant time.
template <std::size_t kArity>
class ConstraintSlots {
 public:
  using Record = ConstraintRecord<kArity>;

  ConstraintSlots() = default;

  /// @param records   [id_count]
  /// @param group_of  [id_count] kInvalidIndex where an id stands for no constraint
  ConstraintSlots(std::span<const Record> records, std::vector<Index> group_of)
      : slot_of_id_(records.size(), kInvalidIndex), group_of_id_(std::move(group_of)) {
    for (const Index group : group_of_id_) {
      if (group != kInvalidIndex) {
        counts_.resize(std::max<std::size_t>(counts_.size(), group + 1), 0);
        ++counts_[group];
      }
    }
    Index slot_count = 0;
    for (Index& count : counts_) {
      begins_.push_back(slot_count);
      slot_count += std::exchange(count, 0);
    }
    records_.resize(slot_count);
    multipliers_.resize(slot_count, 0.0F);
    id_of_slot_.resize(slot_count);
    for (std::size_t id = 0; id < records.size(); ++id) {
      const Index group = group_of_id_[id];
      if (group != kInvalidIndex) {
        const Index slot = begins_[group] + counts_[group]++;
        records_[slot] = records[id];
        id_of_slot_[slot] = static_cast<Index>(id);
        slot_of_id_[id] = slot;
      }
    }
  }

  [[nodiscard]] Index group_count() const noexcept { return static_cast<Index>(counts_.size()); }
  /// Groups beyond the last are empty, too.
  [[nodiscard]] bool is_empty(Index group) const noexcept {
    return group >= group_count() || counts_[group] == 0;
  }
  [[nodiscard]] bool is_alive(Index id) const noexcept { return slot_of_id_[id] != kInvalidIndex; }

  [[nodiscard]] std::span<const Record> records(Index group) const noexcept {
    return {records_.data() + begins_[group], static_cast<std::size_t>(counts_[group])};
  }
  [[nodiscard]] std::span<float> multipliers(Index group) noexcept {
    return {multipliers_.data() + begins_[group], static_cast<std::size_t>(counts_[group])};
  }
  void reset_multipliers() noexcept { multipliers_.assign(multipliers_.size(), 0.0F); }

  [[nodiscard]] const Record& record(Index id) const noexcept { return records_[slot_of_id_[id]]; }
  void set_rest(Index id, float rest) noexcept { records_[slot_of_id_[id]].rest = rest; }

  void remove(Index id) noexcept {
    const Index group = group_of_id_[id];
    const Index slot = slot_of_id_[id];
    const Index last = begins_[group] + --counts_[group];
    std::swap(records_[slot], records_[last]);
    std::swap(multipliers_[slot], multipliers_[last]);
    std::swap(id_of_slot_[slot], id_of_slot_[last]);
    slot_of_id_[id_of_slot_[slot]] = slot;
    slot_of_id_[id] = kInvalidIndex;
  }

 private:
  std::vector<Record> records_;     // [slot]
  std::vector<float> multipliers_;  // [slot] kg m or kg/m
  std::vector<Index> id_of_slot_;   // [slot]
  std::vector<Index> slot_of_id_;   // [id] kInvalidIndex once removed
  std::vector<Index> group_of_id_;  // [id]
  std::vector<Index> begins_;       // [group_count] first slot of each group
  std::vector<Index> counts_;       // [group_count] live slots of each group
};

}  // namespace pbdsurg
