// SPDX-License-Identifier: Apache-2.0
// Substeps where tools are fast.
#include <array>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kStep = 5e-3F, kEdge = 3e-3F, kTop = 3 * kEdge;
const Capsule kRod{{-20e-3F, 0, 0}, {20e-3F, 0, 0}, 0.5e-3F};

// A block with a rod that lies on it, pressed in by a radius.
struct PressedRod {
  explicit PressedRod(const SolverOptions& options = {})
      : solver(testing::make_soft_block({6, 6, 3}, kEdge), options),
        tool(solver.add_tool({&kRod, 1}, testing::at(at))) {
    for (int i = 0; i < 10; ++i) {
      at.z() -= 0.1e-3F;
      usual = move().substeps;
    }
  }

  StepReport move(const Vector3f& way = {0, 0, 0}) {
    at += way;
    solver.move_tool(tool, testing::at(at));
    return solver.step(kStep);
  }

  Vector3f at{9e-3F, 9e-3F, kTop + 1e-3F};
  Solver solver;
  ToolId tool;
  int usual = 0;
};

// Along the block, at right angles to the rod.
Vector3f radii(int substeps, float of_each) {
  return {0, of_each * kRod.radius * static_cast<float>(substeps), 0};
}

}  // namespace

// Would catch a step that does not become finer, or without an end, and one that tells nothing.
TEST_CASE("fast tool: substeps rise with its way, up to four times as many", "[unit]") {
  PressedRod rod;
  REQUIRE(rod.solver.tool_force(rod.tool).z() > 0);
  const int usual = rod.usual;
  CHECK(rod.move(radii(usual, 0.4F)).substeps == usual);
  const StepReport twice = rod.move(radii(usual, -0.99F));
  CHECK(twice.substeps == 2 * usual);
  CHECK(twice.fast_tools == 0);
  CHECK(rod.move().substeps == usual);
  const StepReport most = rod.move(radii(usual, 5));
  CHECK(most.substeps == 4 * usual);
  CHECK(most.fast_tools == 1);
  CHECK(rod.solver.last_report().fast_tools == 1);
}

// Would catch a step that is finer for a tool in the air, for vertices alone, or against options.
TEST_CASE("fast tool: substeps stay where nothing is pressed, or options give them", "[unit]") {
  PressedRod rod;
  for (int i = 0; i < 3; ++i) {  // off the block
    rod.move({0, 0, 10e-3F});
  }
  CHECK(rod.move(radii(rod.usual, 5)).substeps == rod.usual);
  CHECK(rod.solver.last_report().fast_tools == 0);
  PressedRod given({.substeps = 3, .iterations = 4});
  const StepReport report = given.move(radii(3, 2));
  CHECK(report.substeps == 3);
  CHECK(report.fast_tools == 1);
}

}  // namespace pbdsurg
