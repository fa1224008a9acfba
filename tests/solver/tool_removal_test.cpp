// SPDX-License-Identifier: Apache-2.0
// Tools that go while a scene moves.
#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/free_block.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::any_sweeping_method;
using testing::Approx;
using testing::ContainsSubstring;
using testing::kGravity;
using testing::kUsualStep;
using testing::make_free_block;
using testing::mean_of;

}  // namespace

// Would catch a tool that still holds or pushes, and others that change with it.
TEST_CASE("tool removal: what a tool held or bore falls freely", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const bool holds = GENERATE(false, true);
  CAPTURE(static_cast<int>(method), holds);
  Solver solver(make_free_block(), {.method = method, .executor = executor::serial()});
  const ToolId far = solver.add_half_space({{0, 0, -1}});
  const Capsule ball{{0, 0, 0.5F}, {0, 0, 0.5F}, 1e-3F};
  const ToolId tool =
      holds ? solver.add_tool({&ball, 1}, ToolPose::Identity()) : solver.add_half_space({});
  if (holds) {
    solver.grasp(tool, std::array<Index, 4>{0, 4, 20, 24});
  }
  testing::run(solver, kUsualStep, 0.2F);
  REQUIRE(solver.tool_force(tool).norm() > 0.01F);
  const ToolPose pose(Eigen::Translation3f(0, 0, -0.5F));
  solver.move_tool(far, pose);

  solver.remove_tool(tool);

  CHECK(!solver.has_tool(tool));
  CHECK(solver.has_tool(far));
  const double before = mean_of(solver).z();
  testing::run(solver, kUsualStep, 0.1F);
  CHECK(before - mean_of(solver).z() > 0.9 * double{kGravity} * 0.1 * 0.1 / 2);
  CHECK(solver.tool_pose(far).translation() == pose.translation());
  CHECK(solver.tool_contacts(far).empty());
}

// Would catch an id that is given again, or a call that a tool which is gone still takes.
TEST_CASE("tool removal: an id is never used again", "[errors]") {
  Solver solver(make_free_block(), {.copies = 2});
  const ToolId first = solver.add_half_space({}), second = solver.add_half_space({{0, 0, -1}});
  solver.remove_tool(first);
  const ToolId third = solver.add_half_space({{0, 0, -2}});
  CHECK(third != first);
  CHECK(third != second);
  CHECK(!solver.has_tool(ToolId(-1)));
  CHECK(!solver.has_tool(ToolId(3)));

  const auto gone = ContainsSubstring("tool 0 was removed");
  CHECK_THROWS_WITH(solver.remove_tool(first), gone);
  CHECK_THROWS_WITH(solver.move_tool(first, ToolPose::Identity()), gone);
  CHECK_THROWS_WITH(solver.set_joint(first, 0, 0, 1), gone);
  CHECK_THROWS_WITH(solver.grasp(first, std::array<Index, 1>{0}, 0, 1), gone);
  CHECK_THROWS_WITH(solver.release(first), gone);
  CHECK_THROWS_WITH(static_cast<void>(solver.tool_force(first, 1)), gone);
  CHECK_THROWS_WITH(static_cast<void>(solver.tool_pose(first)), gone);
  CHECK_THROWS_WITH(static_cast<void>(solver.tool_contacts(first)), gone);
  CHECK_THROWS_WITH(solver.remove_tool(ToolId(5)), ContainsSubstring("there is no tool 5"));
  CHECK(solver.has_tool(second));

  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  CHECK_THROWS_WITH(solver.release(first), gone);
}

// Would catch a snapshot that brings a tool back, or is refused as it has one more.
TEST_CASE("tool removal: a snapshot from before goes on without the tool", "[property]") {
  const SolverMethod method = any_sweeping_method();
  Solver solver(make_free_block(), {.method = method, .executor = executor::serial()});
  const Capsule bar{{0, -0.1F, -2e-3F}, {0, 0.1F, -2e-3F}, 2e-3F};
  const ToolId tool = solver.add_tool({&bar, 1}, ToolPose::Identity(), {ContactFeatures::all, 0.1F},
                                      std::array{ToolJoint{.capsule_count = 1}});
  const ToolId table = solver.add_half_space({});
  testing::run(solver, kUsualStep, 0.1F);
  const Snapshot snapshot = solver.snapshot();
  solver.remove_tool(tool);
  solver.restore(snapshot);
  CHECK(!solver.has_tool(tool));
  CHECK(solver.tool_contacts(table).empty());
  testing::run(solver, kUsualStep, 0.1F);
  CHECK(solver.tool_force(table).z() < 0);
  for (const SnapshotContact& contact : solver.snapshot().contacts) {
    CHECK(contact.tool == table);
  }
}

// Would catch an undo that gives vertices back to a tool that is gone.
TEST_CASE("tool removal: no undo brings back what the tool held", "[edit]") {
  const SolverMethod method = any_sweeping_method();
  Solver solver(make_free_block(), {.method = method, .executor = executor::serial()});
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, std::array<Index, 1>{0});
  std::vector<Index> all;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    all.push_back(t);
  }
  solver.tissue().apply({.remove_tets = all});
  solver.remove_tool(tool);
  solver.tissue().undo();
  const float before = solver.positions()[0].z();
  testing::run(solver, kUsualStep, 0.1F);
  CHECK(before - solver.positions()[0].z() > 0.9F * kGravity * 0.1F * 0.1F / 2);
}

// Would catch a device that is not told, and one whose steps go on with what the tool had.
TEST_CASE("tool removal: all backends have the same bits after it", "[determinism]") {
  const SolverMethod method = any_sweeping_method();
  const auto run = [&](Executor executor) {
    Solver solver(
        make_free_block(),
        {.method = method, .copies = 2, .executor = std::move(executor), .math = MathMode::strict});
    const Capsule bar{{0, -0.1F, 0}, {0, 0.1F, 0}, 2e-3F};
    const auto add_bar = [&](float x, const ToolSurface& surface) {
      return solver.add_tool({&bar, 1}, ToolPose(Eigen::Translation3f(x, 0, -2e-3F)), surface);
    };
    const std::array<ToolId, 3> bars{add_bar(5e-3F, {ContactFeatures::vertices}),
                                     add_bar(10e-3F, {ContactFeatures::vertices, 0.1F}),
                                     add_bar(15e-3F, {ContactFeatures::vertices, 0.2F})};
    const ToolId table = solver.add_half_space({{0, 0, -1e-3F}}, 0.2F);
    for (const ToolId tool : {bars[1], bars[0], bars[2]}) {
      testing::run(solver, kUsualStep, 0.05F);
      solver.remove_tool(tool);
    }
    testing::run(solver, kUsualStep, 0.05F);
    CHECK(solver.tool_force(table, 1).z() < 0);
    return std::pair(solver.state_hash(0), solver.state_hash(1));
  };
  const auto serial = run(executor::serial());
  CHECK(serial.first == serial.second);
  CHECK(run(executor::threads(3)) == serial);
  CHECK(run(testing::fake_device()) == serial);
}

}  // namespace pbdsurg
