// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/material.h"

namespace pbdsurg::testing {

/// The options, but with projections, ten substeps and one sweep where they leave these to the
/// scene: for tests of how a solver steps, which shall not change with how the library chooses.
[[nodiscard]] inline SolverOptions small_steps(SolverOptions options = {}) {
  if (options.method == SolverMethod::automatic) {
    options.method = SolverMethod::projection;
  }
  if (options.substeps == kAutomatic) {
    options.substeps = 10;
  }
  if (options.iterations == kAutomatic) {
    options.iterations = 1;
  }
  return options;
}

/// Such steps on one thread.
[[nodiscard]] inline SolverOptions small_serial_steps(SolverMethod method) {
  return small_steps({.method = method, .executor = executor::serial()});
}

/// The paper's springs; rigid in compliance mode.
inline const Material kSprings{.model = ElasticModel::springs};

}  // namespace pbdsurg::testing
