// SPDX-License-Identifier: Apache-2.0
// Tools that springs tie to where they are to be.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/spring_motion.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::Approx;
using testing::at;
using testing::ContainsSubstring;
using testing::kBlockMass;
using testing::kGravity;
using testing::quick_options;

constexpr float kStep = 5e-3F;
constexpr float kEdge = 3e-3F;
constexpr float kHeight = 3 * kEdge;  // of the block
constexpr float kRadius = 3e-3F;
constexpr ToolSurface kAll{ContactFeatures::all, 0.2F};
const Capsule kBall{{0, 0, 0}, {0, 0, 0}, kRadius};

SolverMethod any_method() {
  return GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
}

Scene make_block(float stiffness) {
  return testing::make_soft_block({6, 6, 3}, double{kEdge}, testing::tissue(stiffness));
}

const Vector3f kTouch(3.3F * kEdge, 2.9F * kEdge, kHeight + kRadius);

// Down to a depth within half a second, then waits.
template <class Look>
void press(Solver& solver, ToolId tool, const Vector3f& touch, float depth, const Look& look) {
  constexpr int kSteps = 100;
  for (int i = 1; i <= 2 * kSteps; ++i) {
    const float share = std::min(1.0F, static_cast<float>(i) / kSteps);
    solver.move_tool(tool, at(touch - Vector3f(0, 0, share * depth)));
    solver.step(kStep);
    look(i);
  }
}

Vector3f pulled(const Solver& solver, ToolId tool) {
  return solver.tool_target(tool).translation() - solver.tool_pose(tool).translation();
}

}  // namespace

// Would catch a spring that is not in the solution: a lag, a tool that is elsewhere than contacts
// see it, a hand that pushes harder than its spring, and tissue so stiff that the tool trembles.
TEST_CASE("coupled tool: tissue pushes it away by its force over the stiffness", "[validation]") {
  // Pa; for projections the stiffer takes a thousand substeps
  const auto [method, tissue] = GENERATE(std::pair(SolverMethod::projection, 10e3F),
                                         std::pair(SolverMethod::vertex_block, 10e3F),
                                         std::pair(SolverMethod::vertex_block, 1e6F));
  const float stiffness = GENERATE(300.0F, 1000.0F);
  CAPTURE(static_cast<int>(method), tissue, stiffness);
  Solver solver(make_block(tissue), quick_options(method, {}, executor::serial()));
  const ToolId tool = solver.add_tool({&kBall, 1}, at(kTouch), kAll);
  solver.couple_tool(tool, {stiffness});
  constexpr float kDepth = 2e-3F;
  float least = 1e9F, most = 0;

  press(solver, tool, kTouch, kDepth, [&](int i) {
    const float force = solver.tool_force(tool).norm();
    const float depth = kTouch.z() - solver.tool_target(tool).translation().z();
    CHECK(force <= 1.001F * stiffness * depth);
    if (i > 150) {
      least = std::min(least, force);
      most = std::max(most, force);
    }
  });

  const Vector3f force = solver.tool_force(tool);
  CHECK(force.z() > 0.02F);
  CHECK((force + stiffness * pulled(solver, tool)).norm() < 1e-2F * force.norm());
  CHECK(most - least < 1e-2F * most);
  CHECK(solver.tool_pose(tool).translation().z() > kTouch.z() - kDepth);
}

// Would catch a tool that is not where it is to be with nothing around it.
TEST_CASE("coupled tool: it moves freely without a lag", "[unit]") {
  const SolverMethod method = any_method();
  Solver solver(make_block(10e3F), quick_options(method, {}, executor::serial()));
  const ToolId tool = solver.add_tool({&kBall, 1}, at({0, 0, 0.1F}), kAll);
  solver.couple_tool(tool, {300});
  for (int i = 1; i <= 10; ++i) {
    const ToolPose pose = at({0, 0, 0.1F + 5e-3F * static_cast<float>(i)}) *
                          Eigen::AngleAxisf(0.1F, Vector3f::UnitX());
    solver.move_tool(tool, pose);
    solver.step(kStep);
    CHECK(solver.tool_pose(tool).matrix() == pose.matrix());
  }
}

namespace {

// A wall in the plane of x and y that stands fast, of triangles much larger than tools.
Scene make_wall() {
  const testing::SheetMesh mesh = testing::make_sheet({2, 2}, 50e-3);
  Scene scene;
  const BodyId wall = scene.add_sheet("wall", mesh.positions, mesh.triangles, {});
  std::vector<Index> all(mesh.positions.size());
  std::iota(all.begin(), all.end(), 0);
  scene.fix_vertices(wall, all);
  scene.set_gravity(Vector3f::Zero());
  return scene;
}

}  // namespace

// Would catch a wall that a tool does not see because none of its corners moves, one that pushes
// with the stiffness of nothing, and another force at its edges than on its faces.
TEST_CASE("coupled tool: a wall that stands fast stops it", "[validation]") {
  const SolverMethod method = any_method();
  const auto offset = GENERATE(Vector3f(60e-3F, 35e-3F, 0), Vector3f(60e-3F, 50e-3F, 0),
                               Vector3f(50e-3F, 50e-3F, 0));  // on a face, an edge, a vertex
  CAPTURE(static_cast<int>(method), offset.x(), offset.y());
  constexpr float kStiffness = 500, kDepth = 5e-3F;
  Solver solver(make_wall(), quick_options(method, {}, executor::serial()));
  const Vector3f touch = offset + Vector3f(0, 0, kRadius);
  const ToolId tool = solver.add_tool({&kBall, 1}, at(touch + Vector3f(0, 0, 1e-3F)), kAll);
  solver.couple_tool(tool, {kStiffness});
  press(solver, tool, touch, kDepth,
        [&](int) { CHECK(solver.tool_pose(tool).translation().z() > 0.99F * kRadius); });
  const Vector3f force = solver.tool_force(tool);
  CHECK(force.z() == Approx(kStiffness * kDepth).epsilon(1e-2));
  CHECK(force.head<2>().norm() < 1e-2F * force.z());
  CHECK(solver.tool_pose(tool).translation().z() == Approx(kRadius).epsilon(1e-2));
}

// Would catch a tool that slides along a wall as if it were smooth, or does not come off it.
TEST_CASE("coupled tool: it slides along a wall with friction, and lifts off", "[validation]") {
  const SolverMethod method = any_method();
  CAPTURE(static_cast<int>(method));
  constexpr float kStiffness = 500, kDepth = 2e-3F;
  Solver solver(make_wall(), quick_options(method, {}, executor::serial()));
  const auto above = [](float x, float z) { return at({20e-3F + x, 35e-3F, kRadius + z}); };
  const ToolId tool = solver.add_tool({&kBall, 1}, above(0, 1e-3F), kAll);
  solver.couple_tool(tool, {kStiffness});
  for (int i = 1; i <= 30; ++i) {
    solver.move_tool(tool, above(0, 1e-3F - 0.1e-3F * static_cast<float>(i)));
    solver.step(kStep);
  }
  for (int i = 1; i <= 100; ++i) {
    solver.move_tool(tool, above(0.2e-3F * static_cast<float>(i), -kDepth));
    solver.step(kStep);
  }
  const Vector3f force = solver.tool_force(tool);
  CHECK(force.z() == Approx(kStiffness * kDepth).epsilon(1e-2));
  CHECK(-force.x() == Approx(kAll.friction * force.z()).epsilon(2e-2));
  for (int i = 1; i <= 40; ++i) {
    solver.move_tool(tool, above(20e-3F, -kDepth + 0.1e-3F * static_cast<float>(i)));
    solver.step(kStep);
  }
  CHECK(solver.tool_force(tool).norm() == 0);
  CHECK(pulled(solver, tool).norm() < 1e-6F);
}

// Would catch a hand that takes its tool through a wall because it is fast, or far beyond it: a rod
// in a channel of eight large triangles that stand fast.
TEST_CASE("coupled tool: none is thrust out of a channel that stands fast", "[validation]") {
  const SolverMethod method = any_method();
  const float step = GENERATE(1e-3F, 5e-3F, 16e-3F);
  CAPTURE(static_cast<int>(method), step);
  const testing::SheetMesh mesh = testing::make_square_tube(10e-3, 60e-3);
  Scene scene;
  const BodyId channel = scene.add_sheet("channel", mesh.positions, mesh.triangles, {});
  scene.fix_vertices(channel, std::array{0, 1, 2, 3, 4, 5, 6, 7});
  scene.set_gravity(Vector3f::Zero());
  const Capsule rod{{0, 0, -20e-3F}, {0, 0, 20e-3F}, 0.5e-3F};
  for (std::uint64_t shot = 0; shot < 20; ++shot) {
    CAPTURE(shot);
    Solver solver(scene, quick_options(method, {}, executor::serial()));
    const ToolId tool = solver.add_tool({&rod, 1}, at(Vector3f::Zero()), kAll);
    solver.couple_tool(tool, {500});
    testing::for_each_thrust(3, shot, step, [&](const Vector3f& place) {
      solver.move_tool(tool, at(place));
      solver.step(step);
      const Vector3f kept = solver.tool_pose(tool).translation();
      CHECK(kept.head<2>().cwiseAbs().maxCoeff() < 5e-3F);
      CHECK(solver.tool_force(tool).norm() < 1.01F * 500 * 20e-3F);
    });
    CHECK((solver.tool_pose(tool).translation()).norm() < 1e-4F);
  }
}

// Would catch points of contacts that count the way of the spring, where the origin of torques does
// not: what pushes a smooth ball pushes towards its middle.
TEST_CASE("coupled tool: a smooth ball that is dragged feels no torque", "[validation]") {
  const SolverMethod method = any_method();
  CAPTURE(static_cast<int>(method));
  Solver solver(make_block(10e3F), quick_options(method, {}, executor::serial()));
  const ToolId tool = solver.add_tool({&kBall, 1}, at(kTouch), {ContactFeatures::all, 0});
  solver.couple_tool(tool, {100});
  float most = 0;
  for (int i = 1; i <= 100; ++i) {
    const float share = static_cast<float>(i) / 100;
    solver.move_tool(tool, at(kTouch + share * Vector3f(4e-3F, 2e-3F, -3e-3F)));
    solver.step(kStep);
    most = std::max(most, solver.tool_force(tool).norm());
    CHECK(solver.tool_torque(tool).norm() < 1e-4F * kRadius * most);
  }
  CHECK(most > 0.05F);
}

// Would catch a stiffness that is off, whatever force and displacement say of each other: a plate
// on a block feels as much as a rigid one that goes as deep, so the springs are in series.
TEST_CASE("coupled tool: its spring and the tissue are in series", "[validation]") {
  const SolverMethod method = any_method();
  CAPTURE(static_cast<int>(method));
  // projections take fewer substeps where both are soft
  const float softness = method == SolverMethod::projection ? 0.1F : 1.0F;
  constexpr float kDepth = 1e-3F;
  const float spring = 500 * softness;
  const auto force_at = [&](float depth, const ToolCoupling& coupling, float& actual) {
    Solver solver(make_block(10e3F * softness), {.method = method, .executor = executor::serial()});
    const ToolId plate = solver.add_half_space({{0, 0, 0}, {0, 0, -1}}, 0, at({0, 0, kHeight}));
    solver.couple_tool(plate, coupling);
    press(solver, plate, {0, 0, kHeight}, depth, [](int) {});
    actual = kHeight - solver.tool_pose(plate).translation().z();
    return solver.tool_force(plate).z();
  };
  float full = 0, actual = 0;
  const float block = force_at(kDepth / 4, {}, full) / (kDepth / 4);  // N/m
  CHECK(full == Approx(kDepth / 4).epsilon(1e-4));
  const float depth = kDepth / 4 * (spring + block) / spring;
  const float force = force_at(depth, {spring}, actual);
  CHECK(force == Approx(depth / (1 / block + 1 / spring)).epsilon(0.02));
  CHECK(actual == Approx(kDepth / 4).epsilon(0.02));
}

// Would catch a spring that only gives way along normals, is stiffer in one copy than in another,
// or whose force is that of another unit: a free block rests on a slope that springs bear.
TEST_CASE("coupled tool: a table gives way by the weight on it", "[validation]") {
  const float factor = GENERATE(1.0F, 2.0F);
  constexpr float kStiffness = 300, kFriction = 0.3F;
  const float slope = 0.7F * std::atan(kFriction);
  Scene scene = testing::make_free_block();
  scene.set_gravity(testing::gravity_on(slope));
  Solver solver(scene, {.method = SolverMethod::vertex_block, .copies = 2});
  solver.set_factors({.stiffness = factor}, 1);
  const ToolId table = solver.add_half_space({}, kFriction);
  solver.couple_tool(table, {kStiffness});
  testing::run(solver, kStep, 1.5F);
  for (const Index copy : {0, 1}) {
    const Vector3f weight = static_cast<float>(kBlockMass) * testing::gravity_on(slope);
    const Vector3f gone = solver.tool_pose(table, copy).translation();
    CHECK((gone - weight / kStiffness).norm() < 1e-2F * weight.norm() / kStiffness);
    CHECK((solver.tool_force(table, copy) - weight).norm() < 1e-2F * weight.norm());
  }
}

// Would catch a tool that leaps through what is between it and where it is to be.
TEST_CASE("coupled tool: what tissue lets go of comes back in strides", "[unit]") {
  Solver solver(make_block(1e6F),
                {.method = SolverMethod::vertex_block, .substeps = 1, .iterations = 10});
  const ToolId tool = solver.add_tool({&kBall, 1}, at(kTouch), kAll);
  solver.couple_tool(tool, {300});
  press(solver, tool, kTouch, 2.5F * kRadius, [](int) {});
  const float before = pulled(solver, tool).norm();
  REQUIRE(before > 2 * kRadius);
  std::vector<Index> all;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    all.push_back(t);
  }
  solver.tissue().apply({.remove_tets = all});
  for (int i = 1; i <= 4; ++i) {
    solver.step(kStep);
    CHECK(pulled(solver, tool).norm() ==
          Approx(before - static_cast<float>(i) * kRadius / 2).epsilon(1e-3));
  }
  testing::run(solver, kStep, 0.1F);
  CHECK(pulled(solver, tool).norm() == 0);
}

// Would catch a tool that leaves the room, as tissue all around it presses on it with thousands of
// newtons that are against each other.
TEST_CASE("coupled tool: it gives way no farther than it and tissue can have moved", "[unit]") {
  constexpr float kStride = 0.25e-3F, kWay = 4e-3F, kMost = kStride + kWay + 1 * kStep;
  const float size = GENERATE(1e-4F, 1e-3F, 25.0F);  // m
  const Vec3<float> before{0, 0, 1e-3F};
  SECTION("away") {
    ToolSpring spring{before, {size, 0, 0}, 1};
    end_spring(kStride, {0, kWay, 0}, kWay, kStep, spring);
    CHECK(spring.displacement.x == Approx(std::min(size, kMost)));
    CHECK(spring.displacement.z == before.z);
    CHECK(spring.shift.x == 0);
  }
  SECTION("back") {
    ToolSpring spring{before, {0, 0, -std::min(size, before.z)}, 1};
    end_spring(kStride, {0, kWay, 0}, kWay, kStep, spring);
    CHECK(spring.displacement.z == Approx(before.z - std::min(size, kStride)));
  }
  SECTION("where it was, while its hand comes back") {
    const float way = std::min(size, before.z);
    ToolSpring spring{before, {0, 0, -way}, 1};
    end_spring(kStride, {0, 0, way}, way, kStep, spring);
    CHECK(spring.displacement.z == Approx(before.z - way).margin(1e-9));
  }
}

// Would catch a displacement that a snapshot or a compaction forgets, and an order of contacts that
// depends on threads.
TEST_CASE("coupled tool: any number of threads has the serial bits, and a snapshot goes on",
          "[determinism]") {
  const SolverMethod method = any_method();
  const auto run = [&](Executor executor, bool restores) {
    Solver solver(make_block(10e3F), {.method = method,
                                      .substeps = 4,
                                      .iterations = 4,
                                      .executor = std::move(executor),
                                      .math = MathMode::strict});
    const ToolId tool = solver.add_tool({&kBall, 1}, at(kTouch), kAll);
    solver.couple_tool(tool, {300});
    for (int i = 1; i <= 30; ++i) {
      solver.move_tool(tool, at(kTouch - 1e-4F * static_cast<float>(i) * Vector3f(0.3F, 0, 1)));
      solver.step(kStep);
      if (restores && i == 20) {
        const Snapshot snapshot = solver.snapshot();
        const Vector3f place = solver.tool_pose(tool).translation();
        solver.step(kStep);
        CHECK(solver.tool_pose(tool).translation() != place);
        solver.restore(snapshot);
        CHECK(solver.tool_pose(tool).translation() == place);
      }
    }
    const std::uint64_t hash = solver.state_hash();
    const Vector3f place = solver.tool_pose(tool).translation();
    Compaction compaction(solver);
    compaction.build();
    compaction.finish(solver);
    CHECK(solver.tool_pose(tool).translation() == place);
    solver.couple_tool(tool, {});
    CHECK((solver.tool_pose(tool).translation() - place).norm() < 1e-8F);
    CHECK(solver.tool_displacement(tool).norm() == 0);
    solver.step(kStep);
    CHECK(pulled(solver, tool).norm() == 0);
    return hash;
  };
  const std::uint64_t serial = run(executor::serial(), false);
  CHECK(run(executor::threads(3), false) == serial);
  CHECK(run(executor::threads(2), true) == serial);
}

TEST_CASE("coupled tool: what cannot be is refused", "[errors]") {
  const auto block = [](const SolverOptions& options = {}) {
    return Solver(make_block(10e3F), options);
  };
  Solver solver = block();
  const ToolId tool = solver.add_tool({&kBall, 1}, at(kTouch), kAll);
  const ToolId plain = solver.add_tool({&kBall, 1}, at(kTouch), {ContactFeatures::vertices});
  CHECK_THROWS_WITH(solver.couple_tool(tool, {0}), ContainsSubstring("coupling is 0 N/m"));
  CHECK_THROWS_WITH(solver.couple_tool(tool, {NAN}), ContainsSubstring("coupling is nan N/m"));
  CHECK_THROWS_WITH(solver.couple_tool(plain, {300}), ContainsSubstring("tool 1 has no surface"));
  CHECK_THROWS_WITH(solver.couple_tool(ToolId(2), {300}), ContainsSubstring("there is no tool 2"));
  solver.grasp(tool, std::array<Index, 1>{150});
  CHECK_THROWS_WITH(solver.couple_tool(tool, {300}), ContainsSubstring("tool 0 holds something"));
  solver.release(tool);
  solver.couple_tool(tool, {300});
  CHECK_THROWS_WITH(solver.grasp(tool, std::array<Index, 1>{150}),
                    ContainsSubstring("tool 0 is coupled by a spring"));
  Snapshot snapshot = solver.snapshot();
  snapshot.tool_displacements[0].x() = NAN;
  CHECK_THROWS_WITH(solver.restore(snapshot), ContainsSubstring("displacement of a tool"));

  Scene undamped;
  undamped.add_body("block", testing::make_box({1, 1, 1}, double{kEdge}), {});
  Solver steps(undamped, {.method = SolverMethod::explicit_steps});
  CHECK_THROWS_WITH(steps.couple_tool(steps.add_tool({&kBall, 1}, at(kTouch), kAll), {300}),
                    ContainsSubstring("in explicit steps no spring holds tools"));
}

}  // namespace pbdsurg
