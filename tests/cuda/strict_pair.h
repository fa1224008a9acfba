// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A solver on a device beside one that is serial.

#include <utility>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/solver_options.h"
#include "tests/support/catch.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {

/// Two strict solvers, to which the same is done.
struct StrictPair {
  StrictPair(const Scene& scene, const SolverOptions& options, DeviceStrategy strategy)
      : serial(scene, with(options, executor::serial(), DeviceStrategy::automatic)),
        device(scene, with(options, cuda::device(), strategy)) {}

  template <class Act>
  void both(const Act& act) {
    act(serial);
    act(device);
  }

  /// @param step  s
  void step_and_compare(float step) {
    INFO(device.backend_name());
    const StepReport expected = serial.step(step);
    const StepReport report = device.step(step);
    REQUIRE_FALSE(report.stalled);
    REQUIRE(report.non_finite_vertices == expected.non_finite_vertices);
    REQUIRE(report.contacts == expected.contacts);
    for (Index copy = 0; copy < serial.options().copies; ++copy) {
      INFO("copy " << copy);
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
    }
  }

  Solver serial, device;

 private:
  static SolverOptions with(SolverOptions options, Executor executor, DeviceStrategy strategy) {
    options.executor = std::move(executor);
    options.device_strategy = strategy;
    options.math = MathMode::strict;
    if (is_explicit(options)) {
      return options;
    }
    if (options.composition == PlanComposition::automatic) {
      options.composition = PlanComposition::separate;
    }
    return small_steps(options);
  }
};

}  // namespace pbdsurg::testing
