// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver is built of, and the building.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/sets/constraint_numbers.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {

class SolverData;

/// What a solver of living tissue starts from: rest, or what another had come to.
struct SolverInput {
  SolverOptions options;                   ///< with a composition that is not automatic
  std::vector<Eigen::Vector3d> positions;  ///< [vertex_count] m, finite; near ones get near places
  ConstraintNumbers numbers;
  SubstepRule substep_rule;
  std::vector<VertexTet> vertex_tets;  ///< [tet_count] of the vertex-block method, else empty
};

/// @param options  with a composition that is not automatic
[[nodiscard]] SolverInput input_at_rest(const Tissue& tissue, const SolverOptions& options);

/// Colours and plans; all but a backend. It does not follow the tissue yet.
[[nodiscard]] std::unique_ptr<SolverData> build_solver_data(const Tissue& tissue,
                                                            SolverInput input);

/// Sets what steps need, also in the plan and its name.
void set_substep_rule(const SubstepRule& rule, SolverData& data);

/// What explicit steps need of what was measured last.
[[nodiscard]] SubstepRule explicit_rule(const SolverData& data) noexcept;

/// Makes room in the tissue for what edits are to add; the solver's own is made by the above.
void reserve_spare_room(Tissue& tissue, const SpareRoom& spare);

}  // namespace pbdsurg
