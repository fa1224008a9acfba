// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a step is divided, where options leave that to the scene: see kAutomatic.

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// What a scene needs; nothing where options give all numbers.
struct SubstepRule {
  float longest = 0;   ///< s, of a substep
  float friction = 0;  ///< 1/s: sweeps more for each second of a substep

  bool operator==(const SubstepRule&) const = default;
};

/// Cost: O(tetrahedra).
/// @throws InvalidArgument  naming the body that needs more than kMostAutomatic
[[nodiscard]] PBDSURG_API SubstepRule substep_rule(const Tissue& tissue,
                                                   const SolverOptions& options);
[[nodiscard]] SubstepRule substep_rule(const Scene& scene, const SolverOptions& options);

/// What two scenes need together.
[[nodiscard]] SubstepRule both(const SubstepRule& a, const SubstepRule& b) noexcept;

struct StepDivision {
  int substeps = 1;
  int sweeps = 1;  ///< of each

  bool operator==(const StepDivision&) const = default;
};

/// @param dt  s, > 0
[[nodiscard]] PBDSURG_API StepDivision divide_step(float dt, const SubstepRule& rule,
                                                   const SolverOptions& options) noexcept;

/// @param rule  of explicit steps, as tissue is now
/// @throws InvalidArgument  if options give substeps that are too few
void check_explicit_step(float dt, const SubstepRule& rule, const SolverOptions& options);

}  // namespace pbdsurg
