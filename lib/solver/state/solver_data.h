// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Everything a solver holds, for the backends that step it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "pbdsurg/base/export.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/coarse_space.h"
#include "lib/solver/methods/contact_firmness.h"
#include "lib/solver/methods/free_pieces.h"
#include "lib/solver/methods/stable_substep.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/sets/constraint_sets.h"
#include "lib/solver/state/contact_bodies.h"
#include "lib/solver/state/custom_sets.h"
#include "lib/solver/state/solver_state.h"
#include "lib/solver/state/tissue_surface.h"

namespace pbdsurg {

class Solver;

/// The parts follow the tissue in the order in which each needs those before it.
class SolverData : public SolverState {
 public:
  static constexpr const char* kWho = "a solver";

  SolverData();
  ~SolverData();
  SolverData(const SolverData&) = delete;
  SolverData& operator=(const SolverData&) = delete;

  /// By which it is known again, also after a compaction; whoever holds on to it keeps others from
  /// having the same.
  std::shared_ptr<const char> identity = std::make_shared<const char>();
  std::unique_ptr<Tissue> own_tissue;  ///< of a solver that was made of a scene
  const Tissue* tissue = nullptr;
  ConstraintSets sets{*this};
  VertexBlocks vertex_blocks;       ///< of methods that move vertices, else empty
  std::uint64_t rows_revision = 0;  ///< changes with these, by an undo, too
  CoarseSpace coarse_space;         ///< of the vertex-block method, if it is asked for
  FreePieces free_pieces;  ///< of the vertex-block method, likewise; as of the step that began last
  StableSubstep stable_substep;            ///< of explicit steps, else empty
  CustomSets custom;                       ///< on a host
  TissueSurface surface{place_of_vertex};  ///< once a tool or a body meets it
  ContactFirmness contact_firmness;        ///< of vertex blocks, while a tool meets surfaces
  ContactBodies contact_bodies;            ///< once bodies meet each other
  StepPlan plan;
  StepScratch step_scratch;  ///< of the first worker on a host

  /// From here on edits of the tissue are followed.
  /// @param before  who followed them until now, if anybody did
  void follow_tissue(SolverData* before = nullptr);
  void leave_tissue() noexcept;

  /// Takes who steps from now on, with the scratch that it needs on a host.
  void set_backend(std::unique_ptr<Backend> made);

  /// @param dt  s, as Solver::step() takes it
  void start_step(float dt);

  /// Surfaces, and what goes with them, as edits have left them.
  void refresh_surfaces();

  /// To the next part of the step, after one that is not the last.
  /// @param stiffest  the largest stiffest_vertex() of the copies
  PBDSURG_API void go_on(float stiffest) noexcept;

  /// Phases follow what tools of any copy hold and what is left, so this is called after each
  /// grasp, release or removal. Cost: O(phases + tools of all copies).
  void rebuild_plan();

  /// Makes the room that options ask for.
  void reserve_spare_room();

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  struct Followers;
  std::unique_ptr<Followers> followers_;
};

/// Calls visit(tet) for those without constraints of their own, dead ones, too.
template <class Visit>
void for_each_tube_tet(const Tissue& tissue, Visit visit) {
  const auto is_tube = [](const Body& body) {
    return body.material.model == ElasticModel::springs && !has_volume_constraints(body);
  };
  if (std::ranges::none_of(tissue.bodies(), is_tube)) {
    return;
  }
  const Index first_later = tissue.first_later_tet(0);
  for (const Body& body : tissue.bodies()) {
    const Index end = std::min(body.first_tet + body.tet_count, first_later);
    for (Index t = body.first_tet; is_tube(body) && t < end; ++t) {
      visit(t);
    }
  }
  for (Index t = first_later; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (is_tube(tissue.bodies()[tissue.body_of_tet(t)])) {
      visit(t);
    }
  }
}

SolverData& solver_data(Solver& solver);
const SolverData& solver_data(const Solver& solver);

}  // namespace pbdsurg
