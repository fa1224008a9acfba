// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From the phases of a plan to the stages of a device. Stages of the vertex-block method are its
/// colours, then strain limits; there are records of all constraints, for the report.

#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

#include "solver/changes.h"
#include "solver/records.h"
#include "solver/solver_data.h"
#include "solver/stages.h"

namespace pbdsurg::cuda {

/// Constraints in the order of the stages.
struct StageRecords {
  std::vector<DistanceRecord> distances;
  std::vector<float> distance_damping;  ///< [distance] s
  std::vector<VolumeRecord> volumes;
  std::vector<JointRecord> joints;
  std::vector<NeoHookeanRecord> neo_hookeans;
  std::vector<StrainLimitRecord> strain_limits;
  std::vector<TubeRecord> tubes;
  std::vector<Index> level_ends;  ///< of serial stages, among the records of their kind
};

class StagePlan {
 public:
  StagePlan() = default;
  StagePlan(const SolverData& data, StageRecords& records);

  [[nodiscard]] std::span<const Stage> stages() const noexcept { return stages_; }

  /// Finds what to write where, so that records follow changes of constraints and tetrahedra. Cost:
  /// proportional to the changes.
  /// @param words  appended to
  /// @return       false if the plan has to be made anew: constraints were added, a serial phase
  ///               has changed, or what came back was gone already when the plan was made
  [[nodiscard]] bool follow(const SolverData& data, const Changes& changes,
                            std::vector<WordChange>& words);

 private:
  /// Where a constraint's numbers are; those removed may come back to where they were.
  struct Location {
    DeviceArray array = DeviceArray::distances;
    Index record = kInvalidIndex;
    Index place = 0;  ///< of an edge among kTetEdges of a joint record
  };
  using Locations = std::vector<Location>;  // [id]

  class Builder;

  [[nodiscard]] Location joint_location(const SolverData& data, Index edge) const;
  bool follow_distance(const SolverData& data, Index id, std::vector<WordChange>& words);
  bool follow_volume(const SolverData& data, Index id, std::vector<WordChange>& words);

  std::vector<Stage> stages_;
  Locations distances_;       // [edge and link]
  Locations volumes_;         // [tet]
  Locations neo_hookeans_;    // [tet]
  Locations strain_limits_;   // [edge]
  std::vector<Index> tubes_;  // [tet] record or kInvalidIndex
};

}  // namespace pbdsurg::cuda
