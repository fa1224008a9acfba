// SPDX-License-Identifier: Apache-2.0
// The vertex-block method: tools that push and hold.
#include <cmath>
#include <limits>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kSoftEdge;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;
using testing::soft_springs;
using testing::vertex_options;

}  // namespace

TEST_CASE("vertex method: the force on a grasper is the weight it holds", "[validation]") {
  const float compliance = GENERATE(0.0F, 1e-3F);
  const bool springs = GENERATE(false, true);
  const TetMesh mesh = testing::make_box({4, 4, 4}, 5e-3);
  Scene scene;
  scene.add_body("block", mesh, springs ? soft_springs(mesh) : neo_hookean(2e4F, 0.4F));
  Solver solver(scene, vertex_options(4, 10, 30));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  std::vector<Index> top;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].y() > 0.0199) {
      top.push_back(v);
    }
  }
  solver.grasp(tool, top, compliance);

  run(solver, 300);

  const double weight = 1000 * 8e-6 * 9.81;
  CHECK(solver.tool_force(tool).y() == Approx(-weight).epsilon(0.02));
  CHECK(std::abs(solver.tool_force(tool).x()) < 0.01 * weight);
  double sag = 0;
  const auto x = solver.positions();
  for (const Index v : top) {
    sag += (scene.positions()[v].y() - x[v].y()) / 25;
  }
  CHECK(sag == Approx(compliance * weight / 25).epsilon(0.02).margin(1e-8));
}

TEST_CASE("vertex method: what lies in a cradle of capsules weighs on it", "[validation]") {
  Scene scene;
  scene.add_particles("particle", std::vector<Eigen::Vector3d>{{0, 0.011, 0}}, 1e-3);
  Solver solver(scene, vertex_options(10, 2, 20));
  const ToolSurface surface{GENERATE(ContactFeatures::vertices, ContactFeatures::all)};
  // two bars, from which the particle is pushed up and inwards; they share the weight
  const ToolId left =
      solver.add_tool(std::vector<Capsule>{{{-0.01F, 0, -0.1F}, {-0.01F, 0, 0.1F}, 0.0125F}},
                      ToolPose::Identity(), surface);
  const ToolId right =
      solver.add_tool(std::vector<Capsule>{{{0.01F, 0, -0.1F}, {0.01F, 0, 0.1F}, 0.0125F}},
                      ToolPose::Identity(), surface);

  const StepReport report = run(solver, 300);

  const double weight = 1e-3 * 9.81;
  CHECK(report.contacts == 2);
  CHECK(solver.positions()[0].y() == Approx(0.0075).epsilon(1e-3));
  for (const ToolId tool : {left, right}) {
    CHECK(solver.tool_force(tool).y() == Approx(-weight / 2).epsilon(0.02));
  }
  // at this angle, the normals lean four parts sideways to three up
  CHECK(solver.tool_force(left).x() == Approx(-weight / 2 * 4 / 3).epsilon(0.02));
}

TEST_CASE("vertex method: a tool dents tissue, feels it, and never enters", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({6, 6, 6}, kSoftEdge), neo_hookean(5e3F, 0.45F));
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.y() < 0.5 * kSoftEdge; });
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, vertex_options(10, 2));
  const float radius = 1.5F * static_cast<float>(kSoftEdge);
  const Eigen::Vector3f above(3 * kSoftEdge, 6 * kSoftEdge + radius, 3 * kSoftEdge);
  ToolPose pose = ToolPose::Identity();
  pose.translation() = above;
  const ToolId tool = solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, radius}}, pose);

  float last = 0;
  for (int i = 1; i <= 40; ++i) {
    pose.translation().y() = above.y() - 1e-4F * static_cast<float>(i);
    solver.move_tool(tool, pose);
    const StepReport report = solver.step(5e-3F);
    CHECK(report.inverted_tets == 0);
    for (const Eigen::Vector3f& x : solver.positions()) {
      CHECK((x - pose.translation()).norm() > 0.995F * radius);
    }
    if (i % 20 == 0) {
      CHECK(solver.tool_force(tool).y() > 1.5F * last);
      last = solver.tool_force(tool).y();
    }
  }
  CHECK(std::abs(solver.tool_force(tool).x()) < 0.05F * last);
}

TEST_CASE("vertex method: two tools that hold one vertex rigidly share it", "[unit]") {
  Scene scene;
  scene.add_particles("particle", std::vector<Eigen::Vector3d>{{0, 0, 0}}, 1e-3);
  Solver solver(scene, vertex_options());
  const ToolId left = solver.add_tool({}, ToolPose::Identity());
  const ToolId right = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(left, std::vector<Index>{0});
  solver.grasp(right, std::vector<Index>{0});
  ToolPose apart = ToolPose::Identity();
  apart.translation().x() = 0.01F;
  solver.move_tool(right, apart);
  run(solver, 3);

  CHECK(solver.positions()[0].x() == Approx(0.005));
  CHECK(solver.tool_force(left).y() == Approx(-1e-3 * 9.81 / 2).epsilon(0.01));
  CHECK(solver.tool_force(right).y() == Approx(-1e-3 * 9.81 / 2).epsilon(0.01));
}

// Would catch a force that takes a lost neighbour in.
TEST_CASE("vertex method: a grasp beside a lost vertex has a force", "[unit]") {
  const float compliance = GENERATE(0.0F, 1e-4F);
  Scene scene = make_bar(neo_hookean(2e4F, 0.4F));
  Solver solver(scene, vertex_options(2, 2));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const Index lost = solver.vertex_count() - 1;
  std::vector<Index> neighbors;
  for (const auto& [a, b] : solver.tissue().edges()) {
    if (a == lost || b == lost) {
      neighbors.push_back(a == lost ? b : a);
    }
  }
  solver.grasp(tool, neighbors, compliance);
  std::vector<Eigen::Vector3f> velocities(solver.positions().size(), Eigen::Vector3f::Zero());
  velocities[lost].setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);
  REQUIRE(solver.step(10.0F).non_finite_vertices == 1);

  const StepReport report = run(solver, 5);

  CHECK(report.non_finite_vertices == 1);
  CHECK(solver.tool_force(tool).allFinite());
}

}  // namespace pbdsurg
