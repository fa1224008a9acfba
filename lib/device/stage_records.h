// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Records of constraints in the order of the stages, and how they are made of a solver's data.

#include <algorithm>
#include <tuple>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/records.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// Of each kind, a list.
template <class... Constraints>
class RecordLists {
 public:
  template <class Constraint>
  [[nodiscard]] std::vector<Record<Constraint>>& of() noexcept {
    return std::get<std::vector<Record<Constraint>>>(lists_);
  }
  template <class Constraint>
  [[nodiscard]] const std::vector<Record<Constraint>>& of() const noexcept {
    return std::get<std::vector<Record<Constraint>>>(lists_);
  }

  /// Calls visit(list) for each kind.
  template <class Visit>
  void for_each_list(Visit visit) const {
    (visit(of<Constraints>()), ...);
  }

 private:
  std::tuple<std::vector<Record<Constraints>>...> lists_;
};

/// A stage may end with spare records, which do nothing until edits bring constraints.
struct StageRecords : ForAllConstraints<RecordLists> {
  std::vector<float> distance_damping;  ///< [distance] s
  std::vector<JointRecord> joints;
  std::vector<TubeRecord> tubes;
  std::vector<Index> level_ends;  ///< of serial stages, among the records of their kind
};

/// Of a live constraint, as it is now.
template <class Constraint>
[[nodiscard]] Record<Constraint> to_record(const ConstraintRecord<Constraint>& from) {
  Record<Constraint> record{};
  std::copy(from.places.begin(), from.places.end(), record.places);
  std::copy_n(from.parameters.begin(), kRecordParameters<Constraint>, record.parameters);
  return record;
}

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
