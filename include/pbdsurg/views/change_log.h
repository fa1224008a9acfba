// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which slots of an array changed, for readers that keep a copy of it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Slots first, ..., end - 1.
struct SlotRange {
  Index first;  ///< the first slot
  Index end;    ///< the one after the last
};

/// Remembers the last changes, for any number of readers, each with the version that it has seen.
class PBDSURG_API ChangeLog {
 public:
  /// For renderers, to whom a call costs more than the bytes.
  static constexpr Index kJoinedGap = 16;

  /// @param slot_count  at least so many changes are remembered
  explicit ChangeLog(Index slot_count = 0);

  /// Grows with every change. Above zero.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_; }

  /// @param slot  not negative, which is not checked
  void note(Index slot) noexcept {
    if (!slots_.empty()) {  // as they are once moved from
      slots_[version_ % slots_.size()] = slot;
    }
    ++version_;
  }

  /// Notes all changes since a version once more: they were taken back.
  void note_again(std::uint64_t since) noexcept;

  /// Lets every reader get all slots once.
  void note_all() noexcept { version_ += slots_.size() + 1; }  // beyond all memory

  /// Remembers at least so many changes from now on. Readers get all slots once if it has to grow.
  void reserve(Index slot_count);

  /// Which slots a reader has to copy that has seen a version, ascending; all, for one far behind.
  /// Cost: O(k log k) in the k changes since.
  /// @param since       a version() read before; zero for a reader that has seen none
  /// @param slot_count  of the array; slots that are no more are left out
  /// @param ranges      replaced
  /// @param gap         ranges less than this apart become one
  void collect(std::uint64_t since, Index slot_count, std::vector<SlotRange>& ranges,
               Index gap = kJoinedGap) const;

 private:
  std::vector<Index> slots_;  // of change v at v % size
  std::uint64_t version_ = 1;
};

}  // namespace pbdsurg
