// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints of one type in colour order, with stable ids.

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/coloring/coloring.h"
#include "pbdsurg/core/types.h"

namespace pbdsurg {

/// What one projection reads, contiguous so that it costs one or two cache lines.
template <std::size_t kArity>
struct ConstraintRecord {
  std::array<Index, kArity> vertices;
  float rest;       ///< m or m^3
  float stiffness;  ///< fraction, or compliance in m/N or m^5/N
};

/// Slots are grouped by colour; an id keeps its meaning while its slot moves. Removing swaps with
/// the last of the same colour, so colours stay contiguous and valid, in constant time.
template <std::size_t kArity>
class ConstraintSlots {
 public:
  using Record = ConstraintRecord<kArity>;

  ConstraintSlots() = default;

  /// @param records  [constraint_count] by id
  ConstraintSlots(std::span<const Record> records, const Coloring& coloring)
      : records_(records.size()),
        multipliers_(records.size(), 0.0F),
        id_of_slot_(records.size()),
        slot_of_id_(records.size()),
        color_of_id_(coloring.color_of),
        begins_(static_cast<std::size_t>(coloring.color_count) + 1, 0),
        counts_(static_cast<std::size_t>(coloring.color_count), 0) {
    for (const Index color : coloring.color_of) {
      ++begins_[color + 1];
    }
    for (Index color = 0; color < coloring.color_count; ++color) {
      begins_[color + 1] += begins_[color];
    }
    for (std::size_t id = 0; id < records.size(); ++id) {
      const Index color = coloring.color_of[id];
      const Index slot = begins_[color] + counts_[color]++;
      records_[slot] = records[id];
      id_of_slot_[slot] = static_cast<Index>(id);
      slot_of_id_[id] = slot;
    }
  }

  [[nodiscard]] Index color_count() const noexcept { return static_cast<Index>(counts_.size()); }
  [[nodiscard]] bool is_alive(Index id) const noexcept { return slot_of_id_[id] != kInvalidIndex; }

  [[nodiscard]] std::span<const Record> records(Index color) const noexcept {
    return {records_.data() + begins_[color], static_cast<std::size_t>(counts_[color])};
  }
  [[nodiscard]] std::span<float> multipliers(Index color) noexcept {
    return {multipliers_.data() + begins_[color], static_cast<std::size_t>(counts_[color])};
  }
  void reset_multipliers() noexcept { multipliers_.assign(multipliers_.size(), 0.0F); }

  [[nodiscard]] const Record& record(Index id) const noexcept { return records_[slot_of_id_[id]]; }
  void set_rest(Index id, float rest) noexcept { records_[slot_of_id_[id]].rest = rest; }

  void remove(Index id) noexcept {
    const Index color = color_of_id_[id];
    const Index slot = slot_of_id_[id];
    const Index last = begins_[color] + --counts_[color];
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
  std::vector<Index> color_of_id_;  // [id]
  std::vector<Index> begins_;       // [color_count + 1] first slot of each colour
  std::vector<Index> counts_;       // [color_count] live slots of each colour
};

}  // namespace pbdsurg
