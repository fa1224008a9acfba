// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How motion and tools follow living tissue.

#include <exception>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// New vertices move as what they are between, and are fixed if that is. A vertex that loses its
/// last tetrahedron stops, and tools let go of it; one that an edit fixes stops. In all copies.
class StateFollower final : public Follower {
 public:
  explicit StateFollower(SolverState& state) : state_(state) {}

  /// Makes room for so many more vertices, and for edits that stop as many.
  void reserve(std::size_t vertices);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Whether tools let go in the last edit, or hold again after its undo.
  [[nodiscard]] bool has_other_holds() const noexcept { return has_other_holds_; }

  void validate(const Tissue& tissue, const TopologyEdit& edit) const override;
  void validate_undo(const Tissue& tissue, const TissueChange& change) const override;
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

 private:
  void keep_motion(const TissueChange& change);
  void collect_motion() const;
  void add_vertex(const Tissue& tissue, const NewVertex& vertex);
  void add_bodies(const Scene& scene, Index first_vertex);
  void set_inverse_masses(const Tissue& tissue, const TissueChange& change);
  void log_fixing(const TopologyEdit& edit);
  void log_tets(const TissueChange& change, std::size_t tet_count);
  void release_dead(const Tissue& tissue);
  void release_dead_points(const Tissue& tissue);
  void hold_again();
  bool release_from(Index vertex);

  SolverState& state_;
  bool has_other_holds_ = false;

  // of the last edit, for its undo
  std::exception_ptr lost_motion_;             // why the device could not keep it
  std::vector<Index> stopped_;                 // vertices
  mutable std::vector<VertexMotion> motions_;  // [copy][stopped_] as they moved before
  std::vector<bool> is_motion_asked_;          // [copy] the backend has its part of `motions_`,
  std::vector<Index> asked_;                   // for these entries of `stopped_`
};

}  // namespace pbdsurg
