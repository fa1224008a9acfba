// SPDX-License-Identifier: Apache-2.0
// Tools with joints: jaws that close, blades that turn.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/contact_stage.h"
#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::Approx;
using testing::ContainsSubstring;
using testing::kBlockMass;
using testing::kUsualStep;
using testing::make_free_block;
using testing::mean_of;

// Two jaws of bars across, above and below testing::make_free_block(), whose hinge is far behind.
struct Jaws {
  static constexpr float kRadius = 3e-3F;
  static constexpr Index kBars = 3;  // of a jaw

  Jaws() {
    for (const float z : {10e-3F + kRadius, -kRadius}) {
      for (const float x : {3e-3F, 10e-3F, 17e-3F}) {
        bars.push_back({{x, -0.1F, z}, {x, 0.1F, z}, kRadius});
      }
    }
  }
  std::vector<Capsule> bars;
  ToolJoint upper{{-0.1F, 0, 5e-3F}, {0, 1, 0}, 0, kBars};
  ToolJoint lower{{-0.1F, 0, 5e-3F}, {0, 1, 0}, kBars, kBars};
};

// Of the contacts of a jaw.
struct JawForces {
  Vector3f sum{0, 0, 0};  // N, on the jaw
  float pressed = 0;      // N, along the normals
};

std::array<JawForces, 2> forces_of(const Solver& solver, ToolId tool) {
  std::array<JawForces, 2> forces;
  for (const ToolContact& contact : solver.tool_contacts(tool)) {
    JawForces& jaw = forces[contact.normal.z() < 0 ? 0 : 1];  // the upper one is first
    jaw.sum += contact.force;
    jaw.pressed -= contact.force.dot(contact.normal);
  }
  return forces;
}

void close(Solver& solver, ToolId tool, float angle, int steps) {
  for (int i = 1; i <= steps; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(steps);
    solver.set_joint(tool, 0, share * angle);
    solver.set_joint(tool, 1, -share * angle);
    solver.step(kUsualStep);
  }
}

}  // namespace

// Would catch joints that turn the wrong way, about the wrong point, all at once or in the wrong
// order, and capsules that stay where the substep began.
TEST_CASE("tool joint: a jaw at a wrist goes where both take it", "[unit]") {
  constexpr float kQuarter = std::numbers::pi_v<float> / 2;
  ToolState tool{.pose = ToolPose(Eigen::Translation3f(0, 0, 1)),
                 .target = ToolPose(Eigen::Translation3f(0, 0, 3))};
  tool.surface.features = ContactFeatures::all;
  tool.capsules = {
      {{0, 0, 0}, {1, 0, 0}, 0.1F}, {{1, 0, 0}, {2, 0, 0}, 0.1F}, {{0, 0, 0}, {0, 0, -1}, 0.1F}};
  tool.joints = {{{{0, 0, 0}, {0, 0, 1}, 0, 2}, 0, kQuarter},
                 {{{1, 0, 0}, {0, 0, 1}, 1, 1}, 0, kQuarter}};
  CopyState copy;
  copy.tools.push_back(tool);

  place_tools(copy, 1, 0.5F);

  const std::vector<Capsule>& now = copy.tools[0].placed_capsules;
  const std::vector<Capsule>& before = copy.tools[0].capsules_before;
  REQUIRE(now.size() == 3);
  REQUIRE(before.size() == 3);
  const float root = std::sqrt(0.5F);
  CHECK((now[0].end - Vector3f(0, 1, 3)).norm() < 1e-6F);
  CHECK((now[1].start - Vector3f(0, 1, 3)).norm() < 1e-6F);
  CHECK((now[1].end - Vector3f(-1, 1, 3)).norm() < 1e-6F);
  CHECK(now[2].end == Vector3f(0, 0, 2));
  CHECK((before[0].end - Vector3f(root, root, 2)).norm() < 1e-6F);
  CHECK((before[1].end - Vector3f(root, root + 1, 2)).norm() < 1e-6F);

  end_tools(copy);
  CHECK(copy.tools[0].joints[1].angle == kQuarter);
}

// Would catch jaws that feel different forces, or none, and closing jaws that throw a block out.
TEST_CASE("tool joint: closing jaws feel equal and opposite forces", "[validation]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  CAPTURE(static_cast<int>(method));
  Scene scene = make_free_block();
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, {.method = method, .executor = executor::serial()});
  const Jaws jaws;
  const ToolId tool = solver.add_tool(jaws.bars, ToolPose::Identity(), {ContactFeatures::all, 0.3F},
                                      std::array{jaws.upper, jaws.lower});
  const Vector3d before = mean_of(solver);

  close(solver, tool, 5e-3F, 100);  // 0.55 mm in the middle of each
  testing::run(solver, kUsualStep, 0.5F);

  const auto [upper, lower] = forces_of(solver, tool);
  CHECK(upper.sum.z() > 0.05F);
  CHECK((upper.sum + lower.sum).norm() < 1e-2F * upper.sum.norm());
  CHECK(solver.tool_force(tool).norm() < 1e-2F * upper.sum.norm());
  CHECK(std::abs(mean_of(solver).z() - before.z()) < 2e-5);
}

// Would catch friction of jaws that is not Coulomb's, on both.
TEST_CASE("tool joint: jaws hold a block, or let it slide", "[validation]") {
  const float friction = GENERATE(0.02F, 0.3F);
  CAPTURE(friction);
  constexpr float kPull = 20;  // m/s^2, along the bars
  Scene scene = make_free_block();
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, testing::vertex_blocks(TimeIntegration::implicit_euler));
  const Jaws jaws;
  const ToolId tool =
      solver.add_tool(jaws.bars, ToolPose::Identity(), {ContactFeatures::all, friction},
                      std::array{jaws.upper, jaws.lower});
  close(solver, tool, 5e-3F, 100);
  testing::run(solver, kUsualStep, 0.5F);
  solver.set_gravity({0, kPull, 0});
  if (friction > 0.1F) {
    testing::run(solver, kUsualStep, 0.5F);
  }
  const auto speed = [&] {  // of a block whose vertices have unequal masses
    double momentum = 0, mass = 0;
    const std::vector<Vector3f> velocities = solver.velocities();
    for (Index v = 0; v < solver.vertex_count(); ++v) {
      momentum += solver.tissue().masses()[v] * double{velocities[v].y()};
      mass += solver.tissue().masses()[v];
    }
    return momentum / mass;
  };
  const double before = mean_of(solver).y(), speed_before = speed();

  constexpr int kCount = 10;
  double dragged = 0, pressed = 0, rubbed = 0;
  for (int i = 0; i < kCount; ++i) {
    solver.step(kUsualStep);
    dragged += solver.tool_force(tool).y() / kCount;
    for (const JawForces& jaw : forces_of(solver, tool)) {
      pressed += jaw.pressed / kCount;
      rubbed += jaw.sum.y() / kCount;
    }
  }

  if (friction > 0.1F) {
    CHECK(dragged == Approx(kBlockMass * kPull).epsilon(0.02));
    CHECK(dragged < friction * pressed);
    CHECK(std::abs(mean_of(solver).y() - before) < 1e-6);
  } else {
    const double gained = (speed() - speed_before) / (kCount * double{kUsualStep});
    CHECK(rubbed == Approx(friction * pressed).epsilon(0.03));  // some of it is across the bars
    CHECK(gained == Approx(kPull - dragged / kBlockMass).epsilon(0.02));
    CHECK(dragged == Approx(rubbed).epsilon(0.05));
  }
}

// Would catch a joint that jumps at the end of a step, or whose motion contacts do not see.
TEST_CASE("tool joint: a blade that turns pushes a ball with omega x r", "[validation]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const ToolSurface surface =
      GENERATE(ToolSurface{}, ToolSurface{.features = ContactFeatures::all});
  CAPTURE(static_cast<int>(method), static_cast<int>(surface.features));
  constexpr float kRadius = 5e-3F, kSpeed = 2;  // m, rad/s
  Scene scene;
  scene.add_particles("ball", std::vector<Vector3d>{{30e-3, 5.1e-3, 0}}, 1e-3);
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, {.method = method, .executor = executor::serial()});
  const Capsule blade{{0, 0, 0}, {80e-3F, 0, 0}, kRadius};
  const ToolId tool = solver.add_tool({&blade, 1}, ToolPose::Identity(), surface,
                                      std::array{ToolJoint{.capsule_count = 1}});
  constexpr int kSteps = 20;
  float angle = 0;
  for (int i = 1; i <= kSteps; ++i) {
    angle = kSpeed * kUsualStep * static_cast<float>(i);
    solver.set_joint(tool, 0, angle);
    solver.step(kUsualStep);
  }

  const Vector3f along(std::cos(angle), std::sin(angle), 0), normal(-along.y(), along.x(), 0);
  const Vector3f x = solver.positions()[0], v = solver.velocities()[0];
  CHECK(x.dot(normal) > 0.99F * kRadius);
  CHECK(x.dot(normal) < 1.1F * kRadius);
  CHECK(v.dot(normal) == Approx(kSpeed * x.dot(along)).epsilon(2e-2));
  CHECK(x.dot(along) > 29e-3F);
}

// Would catch any difference between a jaw at a joint and a tool that moves as the jaw does.
TEST_CASE("tool joint: jaws do what two tools do that move alike", "[equivalence]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  CAPTURE(static_cast<int>(method));
  const Scene scene = make_free_block();
  Solver jointed(scene, {.method = method, .executor = executor::serial()}),
      rigid(scene, {.method = method, .executor = executor::serial()});
  const Vector3f hinge(-0.1F, 0, 5e-3F);
  std::vector<Capsule> bars;  // in the frame of the hinge
  for (const Capsule& bar : Jaws().bars) {
    bars.push_back({bar.start - hinge, bar.end - hinge, bar.radius});
  }
  const ToolSurface surface{ContactFeatures::all, 0.3F};
  const auto pose_at = [&](float angle, float rise) {
    return ToolPose(Eigen::Translation3f(hinge + Vector3f(0, 0, rise)) *
                    Eigen::AngleAxisf(angle, Vector3f::UnitY()));
  };
  const ToolId jaws = jointed.add_tool(
      bars, pose_at(0, 0), surface,
      std::array{ToolJoint{{0, 0, 0}, {0, 1, 0}, 0, 3}, ToolJoint{{0, 0, 0}, {0, 1, 0}, 3, 3}});
  const std::span<const Capsule> all(bars);
  const ToolId upper = rigid.add_tool(all.first(3), pose_at(0, 0), surface);
  const ToolId lower = rigid.add_tool(all.last(3), pose_at(0, 0), surface);

  for (int i = 1; i <= 60; ++i) {
    const float angle = 1e-4F * static_cast<float>(std::min(i, 50));
    const float rise = 2e-4F * static_cast<float>(std::max(0, i - 40));
    jointed.move_tool(jaws, pose_at(0, rise));
    jointed.set_joint(jaws, 0, angle);
    jointed.set_joint(jaws, 1, -angle);
    rigid.move_tool(upper, pose_at(angle, rise));
    rigid.move_tool(lower, pose_at(-angle, rise));
    jointed.step(kUsualStep);
    rigid.step(kUsualStep);
    CAPTURE(i);
    CHECK((mean_of(jointed) - mean_of(rigid)).norm() < 2e-6);
  }

  const auto [above, below] = forces_of(jointed, jaws);
  CHECK(above.sum.z() > 0.05F);
  CHECK((above.sum - rigid.tool_force(upper)).norm() < 0.02F * above.sum.norm());
  CHECK((below.sum - rigid.tool_force(lower)).norm() < 0.02F * below.sum.norm());
}

// Would catch an angle that copies share, that a snapshot or a compaction forgets, that a device
// does not hear of, or whose work depends on threads.
TEST_CASE("tool joint: angles are each copy's own and go along with it", "[property]") {
  const auto run = [](Executor executor) {
    Solver solver(make_free_block(),
                  {.copies = 2, .executor = std::move(executor), .math = MathMode::strict});
    const Jaws jaws;
    const ToolId tool =
        solver.add_tool(jaws.bars, ToolPose::Identity(), {ContactFeatures::vertices, 0.3F},
                        std::array{jaws.upper, jaws.lower});
    Snapshot snapshot;
    for (int i = 1; i <= 20; ++i) {
      const float angle = 3e-4F * static_cast<float>(i);
      solver.set_joint(tool, 0, angle, 1);
      solver.set_joint(tool, 1, -angle, 1);
      CHECK(solver.joint_target(tool, 0, 1) == angle);
      CHECK(solver.joint_angle(tool, 0, 1) < angle);
      solver.step(kUsualStep);
      CHECK(solver.joint_angle(tool, 0, 0) == 0);
      CHECK(solver.joint_angle(tool, 0, 1) == angle);
      if (i == 10) {
        snapshot = solver.snapshot(1);
      }
    }
    const std::uint64_t hash = solver.state_hash(1);
    solver.restore(snapshot, 1);
    CHECK(solver.joint_angle(tool, 0, 1) == 3e-3F);
    snapshot.joint_angles.clear();
    solver.set_joint(tool, 0, 4e-3F, 1);
    solver.restore(snapshot, 1);
    CHECK(solver.joint_target(tool, 0, 1) == 3e-3F);
    Compaction compaction(solver);
    compaction.build();
    compaction.finish(solver);
    CHECK(solver.joint_angle(tool, 1, 1) == -3e-3F);
    return hash;
  };
  const std::uint64_t serial = run(executor::serial());
  CHECK(run(executor::threads(3)) == serial);
  CHECK(run(testing::fake_device()) == serial);
}

TEST_CASE("tool joint: what is out of range is refused", "[errors]") {
  Solver solver(make_free_block());
  const std::vector<Capsule> bars = Jaws().bars;
  const auto check_refused = [&](std::vector<ToolJoint> joints, const char* why) {
    CHECK_THROWS_WITH(solver.add_tool(bars, ToolPose::Identity(), {}, joints),
                      ContainsSubstring(why));
  };
  check_refused({{.axis = {0, 0, 2}, .capsule_count = 1}}, "joint 0 has an axis of length 2");
  check_refused({{.capsule_count = 1}, {.point = {NAN, 0, 0}, .capsule_count = 1}},
                "joint 1 has an axis");
  check_refused({{.capsule_count = 0}}, "turns 0 capsules from 0 on");
  check_refused({{.first_capsule = -1, .capsule_count = 1}}, "turns 1 capsules from -1 on");
  check_refused({{.first_capsule = 4, .capsule_count = 3}}, "some of the tool's 6");
  check_refused(
      {{.first_capsule = 0, .capsule_count = 3}, {.first_capsule = 2, .capsule_count = 2}},
      "joint 1 turns some capsules of joint 0 and others");
  check_refused(
      {{.first_capsule = 0, .capsule_count = 2}, {.first_capsule = 0, .capsule_count = 3}},
      "joint 1 turns some capsules of joint 0 and others");

  const ToolId tool = solver.add_tool(
      bars, ToolPose::Identity(), {},
      std::array{ToolJoint{.capsule_count = 6}, ToolJoint{.first_capsule = 3, .capsule_count = 3}});
  CHECK(tool == 0);  // none of the others came
  CHECK_THROWS_WITH(solver.set_joint(tool, 2, 0),
                    ContainsSubstring("there is no joint 2; the tool has 2"));
  CHECK_THROWS_WITH(static_cast<void>(solver.joint_angle(tool, -1)),
                    ContainsSubstring("no joint -1"));
  CHECK_THROWS_WITH(static_cast<void>(solver.joint_target(ToolId(1), 0)),
                    ContainsSubstring("no tool 1"));
  CHECK_THROWS_WITH(solver.set_joint(tool, 0, NAN), ContainsSubstring("angle of a joint is nan"));
  CHECK(solver.joint_target(tool, 0) == 0);
  Snapshot snapshot = solver.snapshot();
  snapshot.joint_angles[0].pop_back();
  CHECK_THROWS_WITH(solver.restore(snapshot), ContainsSubstring("joints of tool 0 has 1 entries"));
  snapshot.joint_angles[0].push_back(std::numeric_limits<float>::infinity());
  CHECK_THROWS_WITH(solver.restore(snapshot), ContainsSubstring("angle of a joint is inf"));
}

}  // namespace pbdsurg
