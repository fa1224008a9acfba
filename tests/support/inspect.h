// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The one door of tests to what solvers and tissues hold.

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_data.h"
#include "lib/tissue/tissue_data.h"

namespace pbdsurg::testing {

[[nodiscard]] inline const SolverData& inspect(const Solver& solver) {
  return solver_data(solver);
}
[[nodiscard]] inline SolverData& inspect(Solver& solver) {
  return solver_data(solver);
}
[[nodiscard]] inline const TissueData& inspect(const Tissue& tissue) {
  return tissue_data(tissue);
}
[[nodiscard]] inline TissueData& inspect(Tissue& tissue) {
  return tissue_data(tissue);
}

}  // namespace pbdsurg::testing
