// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/grasp_cases.h"

#include <algorithm>
#include <cmath>

#include "bench/contact/blocks.h"
#include "tests/support/held_slab.h"

namespace pbdsurg::bench {
namespace {

using testing::HeldSlab;

ToolId grasp_slab(Solver& solver, const HeldSlab& slab, const Grip& grip) {
  const ToolId tool = solver.add_tool({}, HeldSlab::pose());
  solver.grasp(tool, slab.points(), grip);
  return tool;
}

// Pulls at 8 mm/s until the grip holds no more.
// @return  N, the largest pull
double pull(Solver& solver, ToolId tool) {
  double largest = 0;
  for (int i = 1; solver.tool_grip(tool).state == GripState::holding; ++i) {
    solver.move_tool(tool, HeldSlab::pose({8e-3F * kCaseStep * static_cast<float>(i), 0, 0}));
    solver.step(kCaseStep);
    largest = std::max(largest, double{solver.tool_grip(tool).pull.x()});
  }
  return largest;
}

ContactOutcome slip(SolverOptions options) {
  constexpr float kLimit = 0.3F;
  options.damping = 5;
  const HeldSlab slab;
  Solver solver(slab.scene, options);
  return compare(pull(solver, grasp_slab(solver, slab, HeldSlab::grip(kLimit))), kLimit);
}

// A slab that hangs from the jaws, its weight a share of what they hold. Its weight comes within a
// second.
struct HangingSlab {
  HangingSlab(const SolverOptions& options, float share) : solver(slab.scene, options) {
    float mass = 0;
    for (const double each : solver.tissue().masses()) {
      mass += static_cast<float>(each);
    }
    Grip grip = HeldSlab::grip(mass * kGravity / share);
    grip.pad.half_length = 30e-3F;
    tool = grasp_slab(solver, slab, grip);
    for (int i = 1; i <= 200; ++i) {
      solver.set_gravity({-kGravity * static_cast<float>(i) / 200, 0, 0});
      solver.step(kCaseStep);
    }
  }

  void step_for(double seconds) {
    for (auto left = std::lround(seconds / double{kCaseStep}); left > 0; --left) {
      solver.step(kCaseStep);
    }
  }

  HeldSlab slab{false};
  Solver solver;
  ToolId tool{};
};

ContactOutcome hold(const SolverOptions& options) {
  HangingSlab hanging(options, 0.95F);
  const Eigen::Vector3d before = center_of(hanging.solver);
  hanging.step_for(10);
  return compare_to_zero(1e3 * (center_of(hanging.solver) - before).norm(), 1e3 * HeldSlab::kEdge);
}

// What it speeds up by in 0.1 s, when it slides already.
ContactOutcome slide_in_grip(const SolverOptions& options) {
  constexpr double kShare = 1.05, kTime = 0.1;
  HangingSlab hanging(options, static_cast<float>(kShare));
  hanging.step_for(kTime);
  const double before = hanging.solver.tool_grip(hanging.tool).slid;
  hanging.step_for(kTime);
  const double after = hanging.solver.tool_grip(hanging.tool).slid;
  return compare((after - before) / (kTime * double{kCaseStep}), kGravity * (1 - 1 / kShare));
}

ContactOutcome tear(SolverOptions options) {
  constexpr double kLimit = 0.2, kWidth = 12e-3;
  options.damping = 5;
  const HeldSlab slab;
  Solver solver(slab.scene, options);
  Grip grip = HeldSlab::grip(1);
  grip.tear_strength = static_cast<float>(kLimit / kWidth);
  const ToolId tool = grasp_slab(solver, slab, grip);
  const double largest = pull(solver, tool);
  return solver.tool_grip(tool).state == GripState::torn ? compare(largest, kLimit)
                                                         : compare(0, kLimit);
}

}  // namespace

std::vector<ContactCase> grasp_cases() {
  return {{"grasp slip: a slab that is pulled", "N", "2 mu N", 5, true, slip},
          {"grasp slip: a slab hangs by 1.05 of its limit", "m/s^2", "g - 2 mu N / m", 2, true,
           slide_in_grip},
          {"grasp hold: at 0.95 of it, 10 s", "mm", "none of an edge", 0.2, true, hold},
          {"grasp tear: a slab that is pulled", "N", "strength times width", 5, true, tear}};
}

}  // namespace pbdsurg::bench
