// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From the stages of a device to the program of a cluster.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

#include "solver/cluster_layout.h"
#include "solver/cluster_schedule.h"
#include "solver/stage_plan.h"
#include "solver/stages.h"

namespace pbdsurg::cuda {

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
  Index most_slots = 0;    ///< of a block
  Index most_rounds = 0;   ///< of a block
  Index most_words = 0;    ///< of a round, with targets
  Index thread_count = 0;  ///< that project, of a block
};

/// Where the words of constraints went.
class ClusterRecords {
 public:
  /// Makes a program of stages.
  /// @param block_count  1 to kMostClusterBlocks
  /// @return  nothing if a cluster cannot execute the stages: none, serial or joint ones, too many
  ///          phases, or more vertices than a block has slots
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
  void append_phase(const ClusterSchedule& schedule, Index block, Index phase, const Stage& stage,
                    const StageRecords& records, ClusterProgram& program);

  std::array<std::vector<Location>, kDeviceArrayCount> locations_;  ///< [array][record]
  bool is_damped_ = false;
};

}  // namespace pbdsurg::cuda
