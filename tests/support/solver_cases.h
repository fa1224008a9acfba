// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tests of solvers have in common.

#include "pbdsurg/solver/solver_options.h"

#include "tests/support/catch.h"

namespace pbdsurg::testing {

/// s, that most tests of contact and sheets step by.
inline constexpr float kUsualStep = 5e-3F;

/// kg/m^3, the default of Material.
inline constexpr double kUsualDensity = 1000;

/// How a scene is solved.
struct Recipe {
  const char* name;
  SolverOptions options;
};

/// Of those that sweep; what a test asks of one it asks of the other.
inline SolverMethod any_sweeping_method() {
  return GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
}

}  // namespace pbdsurg::testing
