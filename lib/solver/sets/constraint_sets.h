// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All elastic constraints of a solver, and how they follow living tissue.

#include <array>
#include <cstddef>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/sets/constraint_kinds.h"
#include "lib/solver/sets/constraint_numbers.h"
#include "lib/solver/sets/constraint_slots.h"
#include "lib/solver/sets/distance_ids.h"
#include "lib/solver/sets/edge_owners.h"
#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// One ConstraintSlots a kind.
template <class... Constraints>
class ConstraintStore {
 public:
  template <class Constraint>
  [[nodiscard]] ConstraintSlots<Constraint>& of() noexcept {
    return std::get<ConstraintSlots<Constraint>>(sets_);
  }
  template <class Constraint>
  [[nodiscard]] const ConstraintSlots<Constraint>& of() const noexcept {
    return std::get<ConstraintSlots<Constraint>>(sets_);
  }

  /// Calls visit(set) for each kind, in their order.
  template <class Visit>
  void for_each_set(Visit visit) {
    (visit(of<Constraints>()), ...);
  }
  template <class Visit>
  void for_each_set(Visit visit) const {
    (visit(of<Constraints>()), ...);
  }

  /// Calls visit(set) for the kind that a phase projects: volumes for a joint one, none for phases
  /// of vertices and tools.
  template <class Visit>
  void visit_set(PhaseKind kind, Visit visit) {
    (void)((KindOf<Constraints>::kPhase == elastic(kind) && (visit(of<Constraints>()), true)) ||
           ...);
  }
  template <class Visit>
  void visit_set(PhaseKind kind, Visit visit) const {
    (void)((KindOf<Constraints>::kPhase == elastic(kind) && (visit(of<Constraints>()), true)) ||
           ...);
  }

 private:
  static constexpr PhaseKind elastic(PhaseKind kind) noexcept {
    return kind == PhaseKind::joint ? PhaseKind::volume : kind;
  }

  std::tuple<ConstraintSlots<Constraints>...> sets_;
};

/// What there is of constraints, for who copies it.
struct ConstraintData : ForAllConstraints<ConstraintStore> {
  DistanceIds distance_ids;          // of edges and links
  Index first_joint_group = 0;       // of distances
  std::vector<Phase> phases;         // all that there can be, in order
  std::vector<Index> domain_counts;  // [level] of a nested plan
  bool has_damping = false;          // of any material
  EdgeOwners edge_owners;

  [[nodiscard]] Index last_level() const noexcept {
    return static_cast<Index>(domain_counts.size()) - 1;
  }

  /// Whether a distance is that of an edge with an owner, see EdgeOwners.
  [[nodiscard]] bool is_owned(Index distance) const noexcept {
    const Index edge = distance_ids.edge_of(distance);
    return edge != kInvalidIndex && edge_owners[edge] != kInvalidIndex;
  }

  /// Of the edges at a place in kTetEdges of tetrahedra of one colour.
  [[nodiscard]] Index joint_group(Index color, Index place) const noexcept {
    return first_joint_group + 6 * color + place;
  }

  /// Where a joint plan projects an edge that has an owner.
  [[nodiscard]] Index joint_group_of(
      Index edge, std::span<const std::array<Index, 6>> tet_edges) const noexcept;

  /// How many constraints a phase projects; zero for phases of other kinds.
  [[nodiscard]] Index constraint_count(const Phase& phase) const noexcept;

  /// As they are now.
  [[nodiscard]] EdgeNumbers numbers_of_edge(Index edge) const;
  [[nodiscard]] TetNumbers numbers_of_tet(Index tet) const;
  [[nodiscard]] TriangleNumbers numbers_of_triangle(Index triangle) const;
  [[nodiscard]] HingeNumbers numbers_of_hinge(Index hinge) const;
  [[nodiscard]] StiffLinkNumbers numbers_of_link(Index link) const;
};

/// Distances of edges of springs and of links; bodies without volume constraints have none of
/// these, and Neo-Hookean bodies neither those nor distances.
///
/// Groups are the colours, then overflow; in a nested plan those of each domain. In a joint plan
/// six more groups of distances follow for each group of volumes, one for each of kTetEdges: edges
/// at that place of the tetrahedra that own them. Groups that edits open follow.
class ConstraintSets final : public Follower, public ConstraintData {
 public:
  explicit ConstraintSets(SolverState& state) : state_(state) {}

  /// Makes room for so many more of each, and groups that wait for them.
  void reserve(const SpareRoom& spare);

  /// Whether the last edit or its undo added constraints, gave some other vertices, emptied a group
  /// or filled an empty one.
  [[nodiscard]] bool has_other_phases() const noexcept { return has_other_phases_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  void validate(const Tissue& tissue, const TopologyEdit& edit) const override;
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

 private:
  class Edit;  // one at work, see constraint_edit.cpp

  void finish();

  SolverState& state_;
  bool has_grown_ = false, has_other_phases_ = false;
  std::vector<PhaseKind> opened_groups_;  // by the last edit
  std::vector<bool> is_taken_;            // [group of a kind], scratch
  // [rest volumes of the edit] live tetrahedra around the edges of each, which removals of the same
  // edit change: noted while it is validated
  mutable std::vector<std::array<Index, 6>> edge_tets_before_;
};

}  // namespace pbdsurg
