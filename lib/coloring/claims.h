// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Deciding between constraints that want the same at the same vertex, in parallel and always the
/// same way.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

#include "lib/coloring/constraint_order.h"

namespace pbdsurg {

/// Where claims are put down: every claimant puts its key on all that it wants, where the largest
/// stays; after a barrier, it may have what it wants if its key lies everywhere.
///
/// A key is the number of the round over the claimant's rank in it, so older claims lose by
/// themselves and the table is cleared only when the numbers run out.
struct ClaimTable {
  std::uint32_t* keys = nullptr;  ///< [vertex_count * slots] zero before the first round
  std::uint64_t size = 0;
  /// Places at each vertex, a power of two. Claims of colours that are equal modulo this contend
  /// too: a delay, never a wrong outcome.
  int slots = 1;
  int rank_bits = 1;  ///< ranks are in [0, 2^rank_bits), at most 31

  PBDSURG_HOST_DEVICE std::uint32_t& at(Index vertex, Index color) const {
    return keys[static_cast<std::uint64_t>(vertex) * slots + (color & (slots - 1))];
  }
};

/// A power of two: enough for as many colours, up to a limit that is one itself.
constexpr int slots_for(Index colors, int limit) {
  int slots = 1;
  while (slots < limit && slots < colors) {
    slots *= 2;
  }
  return slots;
}

/// Slots where all claim at once, and where few do. More would save delays, but no time.
inline constexpr int kDiscSlots = 32;
inline constexpr int kBalanceSlots = 8;

/// Bits for ranks of this many claimants.
constexpr int rank_bits_for(Index count) {
  int bits = 1;
  while (bits < 31 && (Index{1} << bits) < count) {
    ++bits;
  }
  return bits;
}

/// The rounds of a program, counted by every worker alike.
class ClaimRounds {
 public:
  PBDSURG_DEVICE ClaimRounds(const ClaimTable& table, std::uint64_t seed)
      : table_(table), seed_(seed) {}

  /// Starts a round. All workers call it, after a barrier that followed the last use of claims.
  template <class Team>
  PBDSURG_DEVICE void next(Team& team) {
    ++stamp_;
    ++round_;
    if ((stamp_ >> (32 - table_.rank_bits)) != 0) {
      for (std::uint64_t i = team.worker(); i < table_.size; i += team.worker_count()) {
        table_.keys[i] = 0;
      }
      stamp_ = 1;
      team.barrier();
    }
    salt_ = random_bits(seed_, round_);
  }

  /// Counts from 1 on.
  [[nodiscard]] PBDSURG_DEVICE std::uint32_t round() const { return round_; }

  /// Unique among the claimants of this round, never zero.
  [[nodiscard]] PBDSURG_DEVICE std::uint32_t key(Index claimant) const {
    return (stamp_ << table_.rank_bits) |
           shuffled_rank(static_cast<std::uint32_t>(claimant), table_.rank_bits, salt_);
  }

 private:
  ClaimTable table_;
  std::uint64_t seed_;
  std::uint64_t salt_ = 0;
  std::uint32_t stamp_ = 0;
  std::uint32_t round_ = 0;
};

}  // namespace pbdsurg
