// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which block of a cluster projects what, and where each vertex goes next.
///
/// Colours meet at barriers because any vertex of a colour may be touched by the next. Here nobody
/// meets: a vertex travels. After each projection it is written to where its next constraint reads
/// it, to the same block's shared memory or straight into another's, which counts what arrives. So
/// the blocks of a cluster wait for what they need and for nothing else, reads are always local,
/// and each vertex meets its constraints in the order of the plan: the bits are those of any other
/// execution of it.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/cluster_slots.h"

namespace pbdsurg::cuda {

/// Where a vertex goes after a constraint.
struct VertexTarget {
  std::uint16_t block = 0;
  std::uint16_t slot = 0;   ///< of that block
  std::uint16_t phase = 0;  ///< that reads it there; phase_count for the end of the sweep

  bool operator==(const VertexTarget&) const = default;
};

/// Places that follow each other, of which near ones have near numbers.
struct PlaceRun {
  Index first;
  Index count;
};

/// One constraint to be scheduled.
struct SweepConstraint {
  /// kInvalidIndex beyond those that it has; all of them if there is no such constraint now.
  std::array<Index, 4> places;

  bool operator==(const SweepConstraint&) const = default;
};

struct ScheduledConstraint {
  std::array<Index, 4> places;  ///< as in SweepConstraint
  std::array<VertexTarget, 4> targets{};
  std::array<std::uint16_t, 4> slots{};  ///< in its block
  Index phase;
  Index block = kInvalidIndex;     ///< kInvalidIndex if nobody projects it
  Index position = kInvalidIndex;  ///< among those of its block and phase
  /// A bit a corner whose vertex comes from or goes to another block.
  std::uint8_t border_corners = 0;
  bool is_removed = false;  ///< it does nothing but let its vertices pass
  bool is_changed = false;  ///< listed in ScheduleChanges::constraints
};

/// What is another since the schedule was made or followed last; for slots, see ClusterSlots. Those
/// whose arrivals are others may repeat.
struct ScheduleChanges {
  std::vector<Index> constraints;  ///< that are projected
  std::vector<Index> stayed;       ///< removed, back, or as they were: where they are, all the same
  std::vector<std::pair<Index, Index>> rounds;    ///< block and phase whose order is another
  std::vector<std::pair<Index, Index>> arrivals;  ///< block and phase
};

class ClusterSchedule {
 public:
  /// @param phases         [phase] constraints that share no vertex, in the order of the plan
  /// @param place_count    vertices
  /// @param ordered        of these, those that are shared out in order; others go to a neighbour
  /// @param block_count    of the cluster, >= 1
  ClusterSchedule(std::span<const std::vector<SweepConstraint>> phases, Index place_count,
                  std::span<const PlaceRun> ordered, int block_count);

  struct Placement {
    Index constraint;
    SweepConstraint next;
  };
  /// Takes over what constraints are now. One that is no more lets its vertices pass where it is,
  /// until another of its phase wants one of them. One that is new is projected where that takes
  /// the fewest messages between blocks. Cost: the constraints at all vertices of those listed, and
  /// of a few more.
  /// @param placements   each constraint once
  /// @param place_count  vertices, which may be more or fewer
  /// @param round_size   constraints that a block projects at once
  /// @param slot_room    slots that a block has; where few are left, no constraint goes that could
  ///                     go elsewhere
  /// @return  false if constraints of a phase share a vertex; nothing is as it should be then
  [[nodiscard]] bool follow(std::span<const Placement> placements, Index place_count,
                            Index round_size, Index slot_room);

  [[nodiscard]] const ScheduleChanges& changes() const noexcept { return changes_; }

  [[nodiscard]] Index block_count() const { return static_cast<Index>(blocks_.size()); }
  [[nodiscard]] Index phase_count() const { return static_cast<Index>(first_.size()) - 1; }
  [[nodiscard]] Index place_count() const { return static_cast<Index>(chains_.size()); }

  /// Adds one to a phase that is no constraint until follow() says so.
  /// @return  its number
  Index add(Index phase);

  /// Number of a constraint that the schedule was made of, by its phase and number there.
  [[nodiscard]] Index number(Index phase, Index constraint) const {
    return first_[phase] + constraint;
  }
  [[nodiscard]] const ScheduledConstraint& constraint(Index number) const {
    return constraints_[number];
  }
  /// What a block projects in a phase; first those of which a vertex comes from or goes to another
  /// block.
  [[nodiscard]] const std::vector<Index>& constraints(Index block, Index phase) const {
    return blocks_[block].constraints[phase];
  }
  [[nodiscard]] Index border_count(Index block, Index phase) const {
    return blocks_[block].border_counts[phase];
  }
  /// Vertices that come from other blocks.
  /// @param phase  phase_count for those that come home
  [[nodiscard]] Index arrivals(Index block, Index phase) const {
    return blocks_[block].arrivals[phase];
  }
  /// A vertex is at home where the first constraint of a sweep takes it.
  [[nodiscard]] const ClusterSlots& slots() const noexcept { return slots_; }

 private:
  struct Visit {
    Index constraint;
    std::uint16_t phase;
    std::uint8_t corner;
    std::uint8_t block;
  };
  using Chain = std::vector<Visit>;  // by phase
  struct Block {
    std::vector<std::vector<Index>> constraints;  // [phase]
    std::vector<Index> border_counts;             // [phase]
    std::vector<Index> arrivals;                  // [phase_count + 1]
  };

  // A constraint that comes, with the first of its vertices.
  struct Moving {
    Index first_place;
    const Placement* placement;
  };

  /// The first visit in that phase or a later one.
  [[nodiscard]] Chain::const_iterator find_visit(Index place, Index phase) const {
    return std::ranges::lower_bound(chains_[place], phase, {}, &Visit::phase);
  }
  [[nodiscard]] std::size_t round_index(Index block, Index phase) const {
    return static_cast<std::size_t>(block * phase_count() + phase);
  }
  [[nodiscard]] Index choose_block(const ScheduledConstraint& constraint, Index round_size,
                                   Index slot_room) const;
  [[nodiscard]] Index emptiest_block() const;
  [[nodiscard]] bool make_way(Index place, Index phase);
  void assign_blocks(std::span<const std::vector<SweepConstraint>> phases,
                     const std::vector<Index>& parts);
  void forget_changes();
  void mark_constraint(Index n);
  void mark_round(Index block, Index phase);
  void count_arrival(const VertexTarget& target, Index more);
  void touch(Index place);
  void take_out(Index n);
  void put_in(Index n, Index block);
  void link_touched(Index place_count);
  void find_slots(Index place, bool exists);
  void link(Index place);
  void number_constraints(Index block, Index phase);
  void swap_with(Index n, Index other);
  void join_border(Index n);
  void leave_border(Index n);

  std::vector<Block> blocks_;
  std::vector<Index> first_;  // [phase + 1] number of its first constraint
  std::vector<ScheduledConstraint> constraints_;
  std::vector<Chain> chains_;  // [place]
  ClusterSlots slots_;
  ScheduleChanges changes_;
  // while changes are followed
  std::vector<Moving> moving_;
  std::vector<Index> touched_;                 // places whose links are found anew
  std::vector<std::uint8_t> is_touched_;       // [place]
  std::vector<std::uint8_t> is_round_marked_;  // [block][phase]
};

}  // namespace pbdsurg::cuda
