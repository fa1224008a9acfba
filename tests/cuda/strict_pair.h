// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The strict promise: a device has the bits of the serial backend.

#include <utility>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {

/// A solver on a device and one that is serial, to which the same is done.
struct StrictPair {
  StrictPair(const Scene& scene, SolverOptions options, DeviceStrategy strategy)
      : serial(scene, with(options, executor::serial(), DeviceStrategy::automatic)),
        device(scene, with(options, cuda::device(), strategy)) {}

  static SolverOptions with(SolverOptions options, Executor executor, DeviceStrategy strategy) {
    if (options.method != SolverMethod::explicit_steps) {  // which choose by themselves
      options = small_steps(options);
    }
    options.executor = std::move(executor);
    options.device_strategy = strategy;
    options.math = MathMode::strict;
    if (options.method != SolverMethod::explicit_steps &&
        options.composition == PlanComposition::automatic) {
      options.composition = PlanComposition::separate;
    }
    return options;
  }

  template <class Act>
  void both(const Act& act) {
    act(serial);
    act(device);
  }

  void step_and_compare(float dt) {
    INFO(device.backend_name());
    const StepReport expected = serial.step(dt);
    const StepReport report = device.step(dt);
    REQUIRE_FALSE(report.stalled);
    REQUIRE(report.non_finite_vertices == expected.non_finite_vertices);
    REQUIRE(report.contacts == expected.contacts);
    for (Index copy = 0; copy < serial.options().copies; ++copy) {
      INFO("copy " << copy);
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
    }
  }

  Solver serial, device;
};

}  // namespace pbdsurg::testing
