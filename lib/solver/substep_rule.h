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
  float longest = 0;   ///< s, of a substep with the sweeps that options give, or least_sweeps()
  float friction = 0;  ///< 1/s: sweeps more for each second of a substep

  bool operator==(const SubstepRule&) const = default;
};

/// Of a substep, where they are automatic.
[[nodiscard]] int least_sweeps(const SolverOptions& options) noexcept;

/// Cost: O(tetrahedra).
/// @param options  with the method and the coarse correction that were chosen
/// @throws InvalidArgument  naming the body that needs more than kMostAutomatic
[[nodiscard]] PBDSURG_API SubstepRule substep_rule(const Tissue& tissue,
                                                   const SolverOptions& options);

/// What the stiff links of tissue need beside it with a coarse correction. That moves whole bodies
/// by the force that ends of links ask for where the tissue around them stays: more sweeps make up
/// for it. Cost: O(links + tetrahedra of bodies with such links).
[[nodiscard]] SubstepRule stiff_link_rule(const Tissue& tissue, const SolverOptions& options);

/// The same of bodies that an edit brings, in which no coarse correction takes part.
[[nodiscard]] SubstepRule substep_rule(const Scene& new_bodies, const SolverOptions& options);

/// The same of bodies whose tetrahedra an edit makes stiffer than the material.
[[nodiscard]] SubstepRule substep_rule(const Tissue& tissue, const TopologyEdit& edit,
                                       const SolverOptions& options);

/// What two scenes need together.
[[nodiscard]] SubstepRule both(const SubstepRule& a, const SubstepRule& b) noexcept;

/// Of material that is so many times as stiff for its density: waves are faster by the square root.
[[nodiscard]] SubstepRule hastened(const SubstepRule& rule, double haste) noexcept;

struct StepDivision {
  int substeps = 1;
  int sweeps = 1;  ///< of each

  bool operator==(const StepDivision&) const = default;
};

/// Substeps that follow each other in a step and are alike. Most steps are one part.
struct StepPart {
  StepDivision division;
  float h = 0;          ///< s, of a substep
  float past_h = 0;     ///< s, of that before the first; zero: what each copy remembers
  double start = 0;     ///< share of the step that is done before
  double per_step = 1;  ///< substeps of this length that a whole step would have
  int before = 0;       ///< substeps of the step that are done before
  int after = 0;        ///< that are left after it, as long as these

  [[nodiscard]] bool is_first() const noexcept { return before == 0; }
  [[nodiscard]] bool is_last() const noexcept { return after == 0; }

  /// (0, 1] of the step that is done after a substep of the part.
  [[nodiscard]] float done_after(int substep) const noexcept {
    return static_cast<float>(start + (substep + 1) / per_step);
  }

  /// 1/s^2, what a multiplier adds to the mean force of the step.
  /// @param inverse_dt_squared  1/s^2, of the substep
  [[nodiscard]] float force_per_multiplier(float inverse_dt_squared) const noexcept {
    return inverse_dt_squared / static_cast<float>(per_step);
  }
};

/// A whole step.
/// @param dt  s, > 0
[[nodiscard]] PBDSURG_API StepPart whole_step(float dt, const StepDivision& division) noexcept;

/// The same, but for what comes after so many substeps; all of it if that is half as many at most,
/// so that no part is short.
[[nodiscard]] StepPart first_part(const StepPart& step, int most) noexcept;

/// The next part, likewise: its substeps are as long, or shorter if they need it.
/// @param part     which is not the last
/// @param dt       s, of the step
/// @param longest  s, of a substep from now on
[[nodiscard]] StepPart part_after(const StepPart& part, float dt, double longest,
                                  int most) noexcept;

/// @param dt  s, > 0
/// @param least_substeps  where they are automatic
[[nodiscard]] PBDSURG_API StepDivision divide_step(float dt, const SubstepRule& rule,
                                                   const SolverOptions& options,
                                                   int least_substeps = 1) noexcept;

/// @param rule  of explicit steps, as tissue is now
/// @throws InvalidArgument  if options give substeps that are too few
void check_explicit_step(float dt, const SubstepRule& rule, const SolverOptions& options);

}  // namespace pbdsurg
