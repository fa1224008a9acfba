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

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg::cuda {

/// Where a vertex goes after a constraint.
struct VertexTarget {
  std::uint16_t block;
  std::uint16_t slot;   ///< of that block
  std::uint16_t phase;  ///< that reads it there; phase_count for the end of the sweep
};

/// One constraint to be scheduled.
struct SweepConstraint {
  std::array<Index, 4> places;  ///< kInvalidIndex beyond those that it has
};

struct ScheduledBlock {
  /// [slot] places that the block touches; those at home here come first. A vertex is at home where
  /// the first constraint of a sweep takes it.
  std::vector<Index> places;
  Index home_count = 0;
  /// [phase] constraints of the input; first those of which a vertex comes from or goes to another
  /// block
  std::vector<std::vector<Index>> constraints;
  std::vector<Index> border_counts;  ///< [phase] how many of these
  /// [phase_count + 1] vertices that come from other blocks; the last are those that come home
  std::vector<Index> arrivals;
};

class ClusterSchedule {
 public:
  /// @param phases       [phase] constraints that share no vertex, in the order of the plan
  /// @param place_count  vertices; near ones have near numbers
  /// @param block_count  of the cluster, >= 1
  ClusterSchedule(std::span<const std::vector<SweepConstraint>> phases, Index place_count,
                  int block_count);

  [[nodiscard]] const std::vector<ScheduledBlock>& blocks() const noexcept { return blocks_; }

  /// @param corner  of the constraint
  [[nodiscard]] Index slot(Index phase, Index constraint, int corner) const {
    return visits_[first_visit_[phase] + 4 * static_cast<std::size_t>(constraint) + corner].slot;
  }
  [[nodiscard]] const VertexTarget& target(Index phase, Index constraint, int corner) const {
    return visits_[first_visit_[phase] + 4 * static_cast<std::size_t>(constraint) + corner].target;
  }

 private:
  struct Visit {
    Index slot;
    VertexTarget target;
    bool is_border = false;  // comes from or goes to another block
  };
  std::vector<ScheduledBlock> blocks_;
  std::vector<Visit> visits_;             // four a constraint, phase by phase
  std::vector<std::size_t> first_visit_;  // [phase]
};

}  // namespace pbdsurg::cuda
