// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Records of constraints in the order of the stages, and how they are made of a solver's data.

#include <vector>

#include "pbdsurg/core/types.h"

#include "solver/records.h"
#include "solver/solver_data.h"

namespace pbdsurg::cuda {

/// A stage may end with spare records, which do nothing until edits bring constraints.
struct StageRecords {
  std::vector<DistanceRecord> distances;
  std::vector<float> distance_damping;  ///< [distance] s
  std::vector<VolumeRecord> volumes;
  std::vector<JointRecord> joints;
  std::vector<NeoHookeanRecord> neo_hookeans;
  std::vector<StrainLimitRecord> strain_limits;
  std::vector<BendingRecord> bendings;
  std::vector<TubeRecord> tubes;
  std::vector<Index> level_ends;  ///< of serial stages, among the records of their kind
};

// Of live constraints, as they are now.
[[nodiscard]] DistanceRecord to_record(const ConstraintRecord<DistanceConstraint>& from);
[[nodiscard]] VolumeRecord to_record(const ConstraintRecord<VolumeConstraint>& from);
[[nodiscard]] NeoHookeanRecord to_record(const ConstraintRecord<NeoHookeanConstraint>& from);
[[nodiscard]] StrainLimitRecord to_record(const ConstraintRecord<StrainLimitConstraint>& from);
[[nodiscard]] BendingRecord to_record(const ConstraintRecord<BendingConstraint>& from);

/// The volume of a tetrahedron of a joint plan and the edges that it owns.
[[nodiscard]] JointRecord to_joint_record(const SolverData& data, Index tet);

[[nodiscard]] TubeRecord to_tube_record(const SolverData& data, Index tet);

/// Whether a tetrahedron is live and has no constraints of its own. False for ids beyond those
/// that there are.
[[nodiscard]] bool is_tube(const SolverData& data, Index tet) noexcept;

/// Rest length and stiffness of an edge where a tetrahedron's record has it.
struct OwnedEdge {
  float rest = kNotOwned;  ///< m
  float stiffness = 0;     ///< as in DistanceConstraint
};
[[nodiscard]] OwnedEdge owned_edge(const SolverData& data, Index tet, Index edge);

/// One that does nothing.
template <class Record>
[[nodiscard]] Record no_record() {
  Record record{};
  for (Index& place : record.places) {
    place = kInvalidIndex;
  }
  return record;
}

}  // namespace pbdsurg::cuda
