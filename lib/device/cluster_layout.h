// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A program of a cluster as its kernel reads it, and how a block's shared memory is divided.

#include <cstddef>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

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
/// Of contacts, that a block has near at hand: of as many with surfaces as it has threads, and of
/// more, if its memory has room for them.
inline constexpr Index kStagedClusterCorners = 3 * kFewClusterThreads;
inline constexpr Index kMostStagedCorners = 4 * 512;

struct ClusterBlock {
  std::uint32_t first_place;  ///< in ClusterArrays::places
  std::uint32_t home_count;   ///< of these; in slots 0 on
  std::uint32_t slot_count;
  std::uint32_t first_round;
  std::uint32_t round_count;
};

/// How large a program is, or may become by edits. A launch depends on these alone, so they stay
/// while a program follows edits.
struct ClusterSizes {
  Index block_count = 0;
  Index phase_count = 0;
  Index thread_count = 0;  ///< of a block, that project
  Index slot_room = 0;     ///< of a block
  Index round_room = 0;    ///< of a block
  Index round_words = 0;   ///< of the largest round, with targets
  Index place_room = 0;
  std::size_t word_room = 0;
  std::size_t multiplier_room = 0;
};

/// Where the arrays of a program start in its image, which is one piece of memory: numbers of four
/// bytes. All that edits change is in it.
struct ClusterSections {
  std::size_t rounds = 0;  ///< ClusterRound[block][round_room]
  std::size_t blocks;      ///< ClusterBlock[block]
  std::size_t places;      ///< Index[block][slot_room] 0 in slots that are free
  std::size_t arrivals;    ///< uint32[block][phase_count + 1] bytes
  std::size_t homes;       ///< uint32[place_room] block << 16 | slot
  std::size_t words;       ///< Word128[word_room]

  constexpr explicit ClusterSections(const ClusterSizes& sizes)
      : blocks(rounds + count(sizes.block_count, sizes.round_room) * numbers<ClusterRound>),
        places(blocks + count(sizes.block_count) * numbers<ClusterBlock>),
        arrivals(places + count(sizes.block_count, sizes.slot_room)),
        homes(arrivals + count(sizes.block_count, sizes.phase_count + 1)),
        words((homes + count(sizes.place_room) + 3) / 4 * 4) {}  // a Word128 is aligned

 private:
  template <class T>
  static constexpr std::size_t numbers = sizeof(T) / sizeof(std::uint32_t);
  static constexpr std::size_t count(Index rows, Index columns = 1) {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  }
};

/// How many rounds' words a block holds at a time: the one at work, the one before, whose place is
/// free for the next, and two on their way.
inline constexpr std::uint32_t kClusterStages = 4;

/// See ClusterSections.
struct ClusterArrays {
  const ClusterBlock* blocks;
  const Index* places;
  const ClusterRound* rounds;
  const std::uint32_t* arrivals;
  const std::uint32_t* homes;
  const Word128* words;
  float* multipliers;  ///< [copy][multiplier_count]
  std::size_t multiplier_count;
  std::uint32_t block_count;
  std::uint32_t phase_count;
  std::uint32_t slot_room;   ///< of a block
  std::uint32_t round_room;  ///< of a block
  std::uint32_t stage_bytes;
};

/// What a launch sweeps.
struct ClusterSweep {
  Index substep;
  Index sweep_count;
  bool has_attachments;
  bool has_pushers;
  bool has_meeters;
  // extra phases
  bool has_grips;
  bool has_touches;
};

/// Bytes from the start of a block's shared memory.
struct ClusterLayout {
  std::uint32_t slots = 0;    ///< float4[slot_room] what moves, and inverse masses
  std::uint32_t bases;        ///< float4[slot_room] in compliance mode: from where that counts
  std::uint32_t carries;      ///< float4[slot_room] where there is damping
  std::uint32_t stages;       ///< [kClusterStages][stage_bytes]
  std::uint32_t rounds;       ///< ClusterRound[round_room + 1] the last is the first again
  std::uint32_t arrived;      ///< barrier[phase_count + 1] completed by what arrives for a phase
  std::uint32_t fetched;      ///< barrier[kClusterStages] completed by the words of a round
  std::uint32_t surfaces;     ///< barrier[2] all are at home; contacts have moved them
  std::uint32_t board;        ///< uint32[4] CrewBoard
  std::uint32_t held;         ///< uint2[slot_room] slot and index of a vertex that tools hold
  std::uint32_t touched;      ///< uint32[slot_room] slot of a vertex that tools touch
  std::uint32_t tool_counts;  ///< uint32[2] of these lists
  std::uint32_t arrivals;     ///< uint32[phase_count + 1]
  std::uint32_t corners;      ///< float4[kStagedClusterCorners] of contacts; all that is behind
  std::uint32_t size;

  PBDSURG_HOST_DEVICE constexpr ClusterLayout(const ClusterArrays& cluster, bool has_displacements,
                                              bool is_damped)
      : bases(16 * cluster.slot_room),
        carries(bases + (has_displacements ? 16 * cluster.slot_room : 0)),
        stages(carries + (is_damped ? 16 * cluster.slot_room : 0)),
        rounds(stages + kClusterStages * cluster.stage_bytes),
        arrived(rounds + 16 * (cluster.round_room + 1)),
        fetched(arrived + 8 * (cluster.phase_count + 1)),
        surfaces(fetched + 8 * kClusterStages),
        board(surfaces + 16),
        held(board + 16),
        touched(held + 8 * cluster.slot_room),
        tool_counts(touched + 4 * cluster.slot_room),
        arrivals(tool_counts + 8),
        corners((arrivals + 4 * (cluster.phase_count + 1) + 15) / 16 * 16),
        size(corners + 16 * kStagedClusterCorners) {}
};

}  // namespace pbdsurg::cuda
