// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From the stages of a device to the program of a cluster, which follows edits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/cluster_layout.h"
#include "lib/device/cluster_schedule.h"
#include "lib/device/cluster_shapes.h"
#include "lib/device/range_pool.h"
#include "lib/device/stage_plan.h"
#include "lib/device/stages.h"

namespace pbdsurg::cuda {

/// How much more edits find room for in a block's shared memory, which is small.
enum class GrowthRoom : std::uint8_t {
  none,
  some,   ///< an eighth more vertices, a quarter more constraints in the largest round
  ample,  ///< half as many more vertices, twice as many constraints
};

/// What a kernel needs to sweep, as it lies on the device, and what the host needs to change it.
class ClusterProgram {
 public:
  /// Makes a program of stages. Records without places are of no constraint yet.
  /// @param place_count    vertices
  /// @param ordered        see ClusterSchedule
  /// @param block_count    1 to kMostClusterBlocks
  /// @return  nothing if a cluster cannot execute the stages: none, serial or joint ones, too many
  ///          phases, or more vertices than a block has slots
  [[nodiscard]] static std::optional<ClusterProgram> make(
      std::span<const Stage> stages, const StageRecords& records, Index place_count,
      std::span<const PlaceRun> ordered, Index block_count, bool is_damped, GrowthRoom room);

  /// Follows changes of records: parameters, constraints that go, come back, come anew or get other
  /// vertices. Cost: see ClusterSchedule::follow(), and the rounds that these are in.
  ///
  /// Between two launches all numbers may change, those of arrivals, too: each launch makes its
  /// barriers anew and reads for itself what they wait for, and whatever that is, a barrier
  /// completes once a sweep. So its parity is that of the sweep in each block, whatever came
  /// before.
  /// @param words        changes of records; those of other arrays are ignored. Changes of
  ///                     DeviceArray::cluster are appended, each word once
  /// @param place_count  vertices, which may be more or fewer than before
  /// @return  false if there is no room; the program is good for nothing then
  [[nodiscard]] bool follow(std::vector<WordChange>& words, Index place_count);

  [[nodiscard]] const ClusterSizes& sizes() const noexcept { return sizes_; }
  /// See ClusterSections.
  [[nodiscard]] std::span<const std::uint32_t> image() const noexcept { return image_; }

 private:
  /// A round and how far it may grow where it is.
  struct Round {
    ClusterRound now{};
    RangePool::Range words;
    RangePool::Range multipliers;
    // of what the image has of it
    std::uint32_t written_first = kNotWritten;
    std::uint32_t written_count = 0;
  };
  static constexpr std::uint32_t kNotWritten = 0xffffffff;
  static constexpr Index kOfPhase = kInvalidIndex - 1;
  struct Block {
    std::vector<Round> rounds;
    std::vector<Index> first_rounds;  // [phase + 1]
    bool is_changed = false;          // its rounds or slots, since it was written
  };

  ClusterProgram(std::span<const Stage> stages, const StageRecords& records, bool is_damped,
                 GrowthRoom room);
  void make_schedule(Index place_count, std::span<const PlaceRun> ordered, Index block_count);
  void find_sizes();
  void write_all();

  /// Of a record, kInvalidIndex if the stages have none such.
  [[nodiscard]] Index constraint_of(DeviceArray array, std::size_t record);
  /// Lists constraints whose records changed as `placements_`.
  /// @return  false if records are not those of the stages
  [[nodiscard]] bool take_over(std::span<const WordChange> changes);
  [[nodiscard]] bool write_changes();

  void count_rounds(Index block, Index phase);
  [[nodiscard]] bool write_phase(Index block, Index phase);
  [[nodiscard]] bool fit(Round& round);
  [[nodiscard]] std::size_t most_words(const ClusterRound& round) const;
  [[nodiscard]] std::size_t with_room(std::size_t count) const;
  [[nodiscard]] static std::size_t multipliers_of(const ClusterRound& round);

  [[nodiscard]] std::vector<std::uint32_t>& numbers(DeviceArray array);
  [[nodiscard]] const std::uint32_t* record_of(Index n) const;
  [[nodiscard]] const ClusterRound& round_of(const ScheduledConstraint& constraint) const;
  [[nodiscard]] std::size_t head_of(const ScheduledConstraint& constraint) const;
  void write_constraint(Index n);
  void write_slot(Index block, Index slot);
  void write_arrivals(Index block, Index phase);
  void write_block(Index block);
  void write(std::size_t at, std::span<const std::uint32_t> numbers);

  bool is_damped_;
  GrowthRoom room_;
  ClusterSizes sizes_;
  ClusterSections sections_{ClusterSizes{}};
  std::vector<std::uint32_t> image_;
  std::vector<Stage> stages_;
  std::optional<ClusterSchedule> schedule_;  // always there once a program is made
  std::vector<Block> blocks_;
  RangePool words_{0};        ///< of the image
  RangePool multipliers_{0};  ///< of a copy
  /// [array] records, by their numbers
  std::array<std::vector<std::uint32_t>, kDeviceArrayCount> records_;
  /// [array][record] of schedule; kOfPhase - phase if it has none for the record yet
  std::array<std::vector<Index>, kDeviceArrayCount> constraints_;
  std::vector<Index> record_of_constraint_;
  std::vector<WordChange>* written_ = nullptr;                  ///< where changes are listed
  std::vector<std::pair<Index, const ClusterShape*>> changed_;  ///< constraints, while followed
  std::vector<ClusterSchedule::Placement> placements_;
};

}  // namespace pbdsurg::cuda
