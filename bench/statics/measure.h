// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The number of a case, by a static solution and by a solver.

#include "pbdsurg/solver/solver.h"

#include "bench/statics/cases.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg::bench {

/// A sag in mm, the force on a tool along its way in N, or the moment about the axis of a twist in
/// mN mm.
[[nodiscard]] double expected_value(const Case& each);

/// What a solver comes to.
struct Outcome {
  SolverMethod method;
  CoarseCorrection correction;
  StepDivision division;
  double value;
  double change;  ///< of it from the ninth tenth of the time to the last, as a share
};
[[nodiscard]] Outcome measure(const Case& each, SolverOptions options, double dt, double seconds);

}  // namespace pbdsurg::bench
