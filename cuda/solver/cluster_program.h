// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A schedule of a cluster as its kernel reads it: rounds of constraints, in 16-byte words.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

#include "solver/stage_plan.h"
#include "solver/stages.h"

namespace pbdsurg::cuda {

/// Four numbers of a constraint, as bits.
struct alignas(16) Word128 {
  std::uint32_t x, y, z, w;
};

/// Of a corner's slot: its lowest bits. The bit above says that the vertex goes to another block.
inline constexpr std::uint32_t kSlotMask = 0x7fff;
inline constexpr std::uint32_t kLeaves = 0x8000;

/// What the threads of a block project at once, one constraint each: constraints of one phase.
///
/// From `first` on, for each of `words` in turn, that word of all constraints:
///   0        slots of two corners, 16 bits each; of four, those of the others in the second number
///            (damping for constraints of two); then the first two parameters. A constraint that
///            was removed has no number for the first: it lets vertices pass
///   1 ...    further parameters
/// then, for the first `border` constraints, the targets of their corners (see pack_target()).
struct alignas(16) ClusterRound {
  std::uint32_t first;             ///< Word128
  std::uint32_t first_multiplier;  ///< float; they lie as words do
  std::uint16_t count;
  std::uint16_t border;
  std::uint16_t phase;
  std::uint8_t kind;  ///< PhaseKind
  std::uint8_t words;
};

/// Where a vertex goes: 4 bits of block, 12 of phase, 16 of slot.
[[nodiscard]] constexpr std::uint32_t pack_target(std::uint32_t block, std::uint32_t phase,
                                                  std::uint32_t slot) {
  return block << 28 | phase << 16 | slot;
}
/// In place of the first parameter of a constraint that was removed: not a number.
inline constexpr std::uint32_t kRemovedConstraint = 0x7fffffff;

inline constexpr Index kMostClusterBlocks = 16;
inline constexpr Index kFewClusterThreads = 224;  // with one warp that fetches, eight
inline constexpr Index kManyClusterThreads = 480;
inline constexpr Index kMostClusterPhases = 4095;

struct ClusterBlock {
  std::uint32_t first_place;  ///< in ClusterProgram::places
  std::uint32_t home_count;   ///< of these; in slots 0 on
  std::uint32_t slot_count;
  std::uint32_t first_round;
  std::uint32_t round_count;
};

/// What a kernel needs to sweep.
struct ClusterProgram {
  std::vector<ClusterBlock> blocks;
  std::vector<Index> places;            ///< block by block, [slot]
  std::vector<ClusterRound> rounds;     ///< block by block
  std::vector<std::uint32_t> arrivals;  ///< [block][phase_count + 1] bytes
  std::vector<std::uint32_t> homes;     ///< [place] block << 16 | slot
  std::vector<Word128> words;
  std::size_t multiplier_count = 0;
  Index phase_count = 0;
  Index most_slots = 0;         ///< of a block
  Index most_rounds = 0;        ///< of a block
  Index most_words = 0;         ///< of a round, with targets
  Index thread_count = 0;       ///< that project, of a block
};

/// Where the words of constraints went.
class ClusterRecords {
 public:
  /// Makes a program of stages.
  /// @param block_count  1 to kMostClusterBlocks
  /// @return  nothing if a cluster cannot execute the stages: serial or joint ones, too many phases,
  ///          or more vertices than a block has slots
  [[nodiscard]] std::optional<ClusterProgram> make_program(std::span<const Stage> stages,
                                                           const StageRecords& records,
                                                           Index place_count, Index block_count,
                                                           bool is_damped);

  /// Finds what to write where, so that the program follows the records.
  /// @param changes  of records
  /// @param words    appended to; changes of DeviceArray::cluster
  void follow(std::span<const WordChange> changes, std::vector<WordChange>& words) const;

 private:
  struct Location {
    std::uint32_t word;    ///< Word128
    std::uint32_t stride;  ///< between its words, Word128
  };
  [[nodiscard]] Index words_per_record(DeviceArray array) const noexcept;

  std::array<std::vector<Location>, kDeviceArrayCount> locations_;  ///< [array][record]
  bool is_damped_ = false;
};

}  // namespace pbdsurg::cuda
