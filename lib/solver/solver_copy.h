// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What of a solver to copy, so that another like it need not be coloured anew, and where its
/// vertices and tools are.

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/coarse_space.h"
#include "lib/solver/methods/stable_substep.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/program/backend.h"
#include "lib/solver/sets/constraint_sets.h"
#include "lib/solver/state/contact_bodies.h"
#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Constraints, rows and modes of a solver, as they are when it is made, without tools.
class PBDSURG_API SolverCopy {
 public:
  /// Cost: O(all that there ever was), of memory bandwidth.
  explicit SolverCopy(const Solver& solver);

  /// A solver with these, which follows a tissue from here on. Cost: as above, and that of another
  /// backend.
  /// @param tissue  as the solver's was when this was made
  [[nodiscard]] Solver make(Tissue& tissue) const;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  Backend::Maker make_backend_;
  SolverOptions options_;
  SubstepRule substep_rule_;
  Eigen::Vector3f gravity_;
  std::vector<Eigen::Vector3f> body_gravities_;
  std::vector<Load> gravities_;
  std::vector<Index> place_of_vertex_;
  CopyState state_;
  ConstraintData constraints_;
  VertexBlocks vertex_blocks_;
  CoarseSpace coarse_space_;
  StableSubstep stable_substep_;
  StepPlan plan_;
};

/// All that moves in a solver, and what moves it: of each copy, vertices with the forces at them,
/// and tools with what they hold.
struct SolverMotion {
  struct OfCopy {
    Snapshot snapshot;
    std::vector<ToolState> tools;
    std::vector<BodyContact> body_contacts;  // of the last step
    std::vector<Eigen::Vector3f> watched_positions;
    StepReport report;
    CopyFactors factors;
  };
  std::vector<OfCopy> copies;
  std::vector<Index> watched_places;
  Index steps_since_convergence;
  Eigen::Vector3f gravity;
  std::vector<Eigen::Vector3f> body_gravities;
  std::vector<ContactPair> contact_pairs;  // of bodies
};

[[nodiscard]] PBDSURG_API SolverMotion motion_of(const Solver& solver);

/// Tools included, those that the solver lacks are added.
/// @param solver  with the topology that there was
/// @throws InvalidArgument  as Solver::restore(), add_tool(), grasp() and watch(), or if the copies
///                          differ in number, or in tools
PBDSURG_API void set_motion(Solver& solver, const SolverMotion& motion);

[[nodiscard]] PBDSURG_API std::size_t memory_bytes(const SolverMotion& motion) noexcept;

}  // namespace pbdsurg
