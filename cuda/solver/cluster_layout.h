// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A program of a cluster on the device, and how a block's shared memory is divided.

#include <cstdint>

#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/types.h"

#include "solver/cluster_program.h"

namespace pbdsurg::cuda {

/// How many rounds' words a block holds at a time: the one at work, the one before, whose place is
/// free for the next, and two on their way.
inline constexpr std::uint32_t kClusterStages = 4;

/// See ClusterProgram.
struct ClusterArrays {
  const ClusterBlock* blocks;
  const Index* places;
  const ClusterRound* rounds;
  const std::uint32_t* arrivals;
  const std::uint32_t* homes;
  const Word128* words;
  float* multipliers;
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
};

/// Bytes from the start of a block's shared memory.
struct ClusterLayout {
  std::uint32_t slots = 0;     ///< float4[slot_room] positions and inverse masses
  std::uint32_t starts;        ///< float4[slot_room] positions at the start of the substep, damped
  std::uint32_t stages;        ///< [kClusterStages][stage_bytes]
  std::uint32_t rounds;        ///< ClusterRound[round_room + 1] the last is the first again
  std::uint32_t arrived;       ///< barrier[phase_count + 1] completed by what arrives for a phase
  std::uint32_t fetched;       ///< barrier[kClusterStages] completed by the words of a round
  std::uint32_t arrivals;      ///< uint32[phase_count + 1]
  std::uint32_t tool_counts;   ///< uint32[2] of the lists below
  std::uint32_t held;          ///< uint2[slot_room] slot and index of a vertex that tools hold
  std::uint32_t touched;       ///< uint32[slot_room] slot of a vertex that tools touch
  std::uint32_t size;

  PBDSURG_HOST_DEVICE constexpr ClusterLayout(const ClusterArrays& cluster, bool is_damped,
                                              const ClusterSweep& sweep)
      : starts(16 * cluster.slot_room),
        stages(starts + (is_damped ? 16 * cluster.slot_room : 0)),
        rounds(stages + kClusterStages * cluster.stage_bytes),
        arrived(rounds + 16 * (cluster.round_room + 1)),
        fetched(arrived + 8 * (cluster.phase_count + 1)),
        arrivals(fetched + 8 * kClusterStages),
        tool_counts(arrivals + 4 * (cluster.phase_count + 2) / 8 * 8),
        held(tool_counts + 8),
        touched(held + (sweep.has_attachments ? 8 * cluster.slot_room : 0)),
        size(touched + (sweep.has_pushers ? 4 * cluster.slot_room : 0)) {}
};

}  // namespace pbdsurg::cuda
