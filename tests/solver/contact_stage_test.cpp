// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

// One particle of 1 g.
Scene make_particle(const Eigen::Vector3d& at) {
  Scene scene;
  scene.add_particles("particle", std::vector<Eigen::Vector3d>{at}, 1e-3);
  return scene;
}

}  // namespace

TEST_CASE("contact: a particle at rest on a sphere weighs on it", "[validation]") {
  Solver solver(make_particle({0, 0.0101, 0}), testing::small_steps({.damping = 20}));
  const ToolId tool =
      solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, 0.01F}}, ToolPose::Identity());

  StepReport report;
  for (int i = 0; i < 200; ++i) {
    report = solver.step(5e-3F);
  }

  CHECK(solver.positions()[0].y() == Approx(0.01).epsilon(1e-4));
  CHECK(solver.tool_force(tool).y() == Approx(-9.81e-3).epsilon(1e-2));
  CHECK(report.contacts == 1);
}

TEST_CASE("contact: a moving capsule pushes and never enters", "[unit]") {
  Scene scene = make_particle({0.03, 0, 0});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps());
  const ToolId tool = solver.add_tool(std::vector<Capsule>{{{0, -0.02F, 0}, {0, 0.02F, 0}, 0.005F}},
                                      ToolPose::Identity());

  ToolPose pose = ToolPose::Identity();
  for (int i = 1; i <= 50; ++i) {
    pose.translation().x() = 0.001F * static_cast<float>(i);
    solver.move_tool(tool, pose);
    solver.step(0.01F);
    CHECK(solver.positions()[0].x() >= pose.translation().x() + 0.005F - 1e-6F);
  }

  CHECK(solver.positions()[0].x() > 0.0549F);
}

// Gives the force its unit: held in the air, a body weighs on the tool with its mass times g.
TEST_CASE("contact: the force on a grasper is the weight it holds", "[validation]") {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  Scene scene;
  scene.add_body("block", testing::make_box({4, 4, 4}, 5e-3), testing::kSprings);
  Solver solver(scene, testing::small_steps({.mode = mode, .substeps = 20, .damping = 30}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  std::vector<Index> top;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].y() > 0.0199) {
      top.push_back(v);
    }
  }
  REQUIRE(top.size() == 25);
  solver.grasp(tool, top);
  for (int i = 0; i < 400; ++i) {
    solver.step(5e-3F);
  }

  const double weight = 1000 * 8e-6 * 9.81;
  CHECK(solver.tool_force(tool).y() == Approx(-weight).epsilon(0.02));
  CHECK(std::abs(solver.tool_force(tool).x()) < 0.01 * weight);
}

TEST_CASE("contact: two tools may hold one vertex, in phases of their own", "[unit]") {
  Solver solver(make_particle({0, 0, 0}), testing::small_steps({.iterations = 20}));
  const ToolId left = solver.add_tool({}, ToolPose::Identity());
  const ToolId right = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(left, std::vector<Index>{0}, 1e-3F);
  solver.grasp(right, std::vector<Index>{0}, 1e-3F);
  CHECK(solver.plan().phases.size() == 2);

  ToolPose apart = ToolPose::Identity();
  apart.translation().x() = 0.01F;
  solver.move_tool(right, apart);
  for (int i = 0; i < 400; ++i) {
    solver.step(5e-3F);
  }
  CHECK(solver.positions()[0].x() == Approx(0.005).epsilon(0.05));

  CHECK_THROWS_WITH(solver.grasp(left, std::vector<Index>{0}), ContainsSubstring("already"));
  CHECK_THROWS_WITH(solver.grasp(left, std::vector<Index>{7}), ContainsSubstring("no vertex 7"));
  CHECK_THROWS_AS(solver.grasp(left, {}, -1.0F), InvalidArgument);
  solver.release(left);
  solver.release(right);
  CHECK(solver.plan().phases.empty());
}

// Would catch a tool that jumps: only one that travels meets what lies in between.
TEST_CASE("contact: a tool travels evenly over the substeps", "[unit]") {
  Scene scene = make_particle({0.03, 0, 0});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.substeps = 100}));
  const ToolId tool =
      solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, 0.005F}}, ToolPose::Identity());
  ToolPose pose = ToolPose::Identity();
  pose.translation().x() = 0.06F;
  solver.move_tool(tool, pose);
  solver.step(0.1F);

  CHECK(solver.positions()[0].x() >= 0.065F - 1e-5F);
}

TEST_CASE("contact: what is held turns with the tool, the short way round", "[unit]") {
  Scene scene = make_particle({0.03, 0, 0});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.substeps = 2}));
  ToolPose start = ToolPose::Identity();
  start.linear() = Eigen::AngleAxisf(0.4F, Eigen::Vector3f::UnitX()).toRotationMatrix();
  start.translation() = Eigen::Vector3f(0.01F, 0, 0);
  const ToolId tool = solver.add_tool({}, start);
  solver.grasp(tool, std::vector<Index>{0});
  ToolPose turned = start;
  turned.prerotate(Eigen::AngleAxisf(1.5707963F, Eigen::Vector3f::UnitZ()));
  turned.translation() = start.translation();
  solver.move_tool(tool, turned);
  solver.step(0.01F);

  // 2 cm from the pivot along x before, along y after; the last substep moved it by the last half
  const Eigen::Vector3f x = solver.positions()[0];
  CHECK((x - Eigen::Vector3f(0.01F, 0.02F, 0)).norm() < 1e-6F);
  const float half = 0.02F * std::sqrt(0.5F);
  const Eigen::Vector3f middle(0.01F + half, half, 0);
  CHECK((solver.velocities()[0] - (x - middle) / 0.005F).norm() < 1e-2F);
}

TEST_CASE("contact: of two capsules the deeper one pushes", "[unit]") {
  const bool deep_first = GENERATE(true, false);
  Scene scene = make_particle({0, 0.004, 0});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.substeps = 1}));
  std::vector<Capsule> capsules{{{0, 0, 0}, {0, 0, 0}, 0.01F},
                                {{0, 0.012F, 0}, {0, 0.012F, 0}, 0.0085F}};
  if (!deep_first) {
    std::swap(capsules[0], capsules[1]);
  }
  solver.add_tool(capsules, ToolPose::Identity());
  solver.step(1e-3F);

  CHECK(solver.positions()[0].y() == Approx(0.01));
}

// Would catch a missing margin: gravity of this substep alone would carry the particle in.
TEST_CASE("contact: a vertex just outside is kept outside by the sweeps", "[unit]") {
  Scene scene;
  scene.add_particles("pair", std::vector<Eigen::Vector3d>{{0, 0.0105, 0}, {0, 0.02, 0}}, 1e-3);
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.fix_vertices(0, std::vector<Index>{1});
  scene.add_link({0, 1, 0.015F, {}});  // pushes the first particle 5 mm towards the tool
  Solver solver(scene, testing::small_steps({.substeps = 1, .iterations = 20}));
  solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, 0.01F}}, ToolPose::Identity());
  solver.step(1e-3F);

  CHECK(solver.positions()[0].y() >= 0.01F - 1e-6F);
}

TEST_CASE("contact: what exceeds the capacity is counted", "[unit]") {
  Scene scene;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10; ++i) {
    points.push_back({1e-4 * i, 1e-3, 0});
  }
  scene.add_particles("grains", points, 1e-6);
  Solver solver(scene, testing::small_steps({.substeps = 1, .contact_capacity = 4}));
  solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, 0.01F}}, ToolPose::Identity(),
                  {ContactFeatures::vertices});

  const StepReport report = solver.step(1e-3F);

  CHECK(report.contacts == 4);
  CHECK(report.dropped_contacts.at_vertices == 6);
  CHECK(report.dropped_contacts.total() == 6);
}

// Would catch a class of contacts that is counted as another, and a step that is refused before it
// is done, or not at all.
TEST_CASE("contact: what exceeds the capacity is counted by class, and refused where asked",
          "[unit]") {
  constexpr double kEdge = 4e-3;
  Scene scene = testing::make_soft_block({3, 3, 1}, kEdge);
  const BodyId upper = scene.add_body(
      "upper",
      testing::placed_box({3, 3, 1}, kEdge,
                          Eigen::Affine3d(Eigen::Translation3d(0.5e-3, 0.5e-3, kEdge + 0.4e-3))));
  const Capsule plate{{0, 6e-3F, 0}, {12e-3F, 6e-3F, 0}, 3e-3F};
  SolverOptions options{.contact_capacity = 2, .executor = executor::serial()};
  const auto dropped_of = [&](bool touches, bool meets) {
    Solver solver(scene, options);
    if (touches) {
      solver.add_tool({&plate, 1}, testing::at({0, 0, 2 * kEdge + 3e-3F}));
    }
    if (meets) {
      solver.set_body_contact(0, upper, {.thickness = 0.5e-3F});
    }
    return solver.step(1e-3F).dropped_contacts;
  };
  const DroppedContacts of_tools = dropped_of(true, false), of_bodies = dropped_of(false, true);
  CHECK(of_tools.at_surfaces > 0);
  CHECK(of_tools.total() == of_tools.at_surfaces);
  CHECK(of_bodies.of_bodies > 0);
  CHECK(of_bodies.total() == of_bodies.of_bodies);

  Solver counted(scene, options);
  options.refuses_dropped_contacts = true;
  Solver refused(scene, options);
  for (Solver* solver : {&counted, &refused}) {
    solver->set_body_contact(0, upper, {.thickness = 0.5e-3F});
  }
  counted.step(1e-3F);
  CHECK_THROWS_WITH(refused.step(1e-3F), ContainsSubstring("between bodies had no room") &&
                                             ContainsSubstring("contact_capacity is 2"));
  CHECK(refused.state_hash() == counted.state_hash());
  CHECK_NOTHROW(refused.clear_body_contact(0, upper));
  CHECK_NOTHROW(refused.step(1e-3F));
}

}  // namespace pbdsurg
