// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/fake_device.h"
#include "tests/support/free_block.h"
#include "tests/support/held_slab.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::any_sweeping_method;
using testing::Approx;
using testing::check_refused;
using testing::HeldSlab;
using testing::kGravity;
using testing::kUsualStep;

Eigen::Vector3d mean_of(const Solver& solver, const std::vector<Index>& vertices) {
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Index v : vertices) {
    sum += positions[v].cast<double>();
  }
  return sum / static_cast<double>(vertices.size());
}

Eigen::Vector3d center_of(const Solver& solver) {
  std::vector<Index> all(static_cast<std::size_t>(solver.vertex_count()));
  for (std::size_t v = 0; v < all.size(); ++v) {
    all[v] = static_cast<Index>(v);
  }
  return mean_of(solver, all);
}

ToolId grasp_slab(Solver& solver, const HeldSlab& slab, const Grip& grip) {
  const ToolId tool = solver.add_tool({}, HeldSlab::pose());
  solver.grasp(tool, slab.points(), grip);
  return tool;
}

// Pulls along the slab at 8 mm/s, for a time in s; visit() sees each step.
template <class Visit>
void pull(Solver& solver, ToolId tool, float time, const Visit& visit) {
  const float from = (solver.tool_pose(tool).translation() - HeldSlab::pose().translation()).x();
  const auto steps = static_cast<int>(std::lround(time / kUsualStep));
  for (int i = 1; i <= steps; ++i) {
    solver.move_tool(tool,
                     HeldSlab::pose({from + 8e-3F * kUsualStep * static_cast<float>(i), 0, 0}));
    solver.step(kUsualStep);
    visit();
  }
}

double slab_mass(const Solver& solver) {
  double mass = 0;
  for (const double each : solver.tissue().masses()) {
    mass += each;
  }
  return mass;
}

// A slab that hangs from jaws by a share of what they hold, once its weight has come within a
// second.
struct HangingSlab {
  HangingSlab(SolverMethod method, float share)
      : slab(false), solver(slab.scene, {.method = method}) {
    Grip grip = HeldSlab::grip(static_cast<float>(slab_mass(solver)) * kGravity / share);
    grip.pad.half_length = 30e-3F;
    tool = grasp_slab(solver, slab, grip);
    for (int i = 1; i <= 200; ++i) {
      solver.set_gravity({-kGravity * static_cast<float>(i) / 200, 0, 0});
      solver.step(kUsualStep);
    }
  }

  HeldSlab slab;
  Solver solver;
  ToolId tool{};
};

}  // namespace

// Would catch anchors that slide off at once, for what jaws hold moves in part and in part does
// not.
TEST_CASE("grip: jaws slip on vertices that are fixed among others") {
  const SolverMethod method = any_sweeping_method();
  const int substeps = GENERATE(0, 1);  // as many as the method takes, or one long one
  CAPTURE(static_cast<int>(method), substeps);
  HeldSlab slab;
  slab.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() > 31e-3 && x.z() < 1e-9; });
  Solver solver(slab.scene, {.method = method, .substeps = substeps, .iterations = 20 * substeps});
  constexpr float kLimit = 0.2F;
  const ToolId tool = grasp_slab(solver, slab, HeldSlab::grip(kLimit));
  pull(solver, tool, 0.4F, [&] {
    REQUIRE(solver.tool_grip(tool).state != GripState::lost);
    CHECK(solver.tool_grip(tool).pull.norm() < 1.01F * kLimit);
  });
  CHECK(solver.tool_grip(tool).state == GripState::slipping);
  CHECK(solver.tool_grip(tool).pull.norm() == Approx(kLimit).epsilon(0.01));
  CHECK(solver.tool_grip(tool).slid == Approx(8e-3F * kUsualStep).epsilon(0.01));
}

// Would catch a slab that creeps out of jaws that hold more than its weight: over ten seconds.
TEST_CASE("grip: what pulls with less than the limit is held", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  HangingSlab hanging(method, 0.95F);
  Solver& solver = hanging.solver;
  const double weight = slab_mass(solver) * kGravity;
  const Eigen::Vector3d before = center_of(solver);
  for (int i = 0; i < 2000; ++i) {
    solver.step(kUsualStep);
    REQUIRE(solver.tool_grip(hanging.tool).state == GripState::holding);
  }
  CHECK((center_of(solver) - before).norm() < 5e-6);
  CHECK(solver.tool_grip(hanging.tool).pull.x() == Approx(weight).epsilon(0.002));
  CHECK(solver.tool_force(hanging.tool).x() == Approx(-weight).epsilon(0.002));
}

// Would catch jaws that hold more or less than 2 mu N of what slides through them, at rest and in
// motion, and vertices that a released grip leaves held or with other masses.
TEST_CASE("grip: what pulls with more slides, then falls freely", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  HangingSlab hanging(method, 1.05F);
  Solver& solver = hanging.solver;
  const ToolId tool = hanging.tool;
  const float limit = solver.tool_grip(tool).slip_limit;
  REQUIRE(solver.tool_grip(tool).state == GripState::slipping);
  for (int i = 0; i < 20; ++i) {
    solver.step(kUsualStep);
  }
  const float early = solver.tool_grip(tool).slid;
  for (int i = 0; i < 20; ++i) {
    solver.step(kUsualStep);
    CHECK(solver.tool_grip(tool).pull.x() == Approx(limit).epsilon(0.005));
  }
  const float late = solver.tool_grip(tool).slid;
  REQUIRE(solver.tool_grip(tool).points.size() == hanging.slab.points().size());
  CHECK((late - early) / (20 * kUsualStep * kUsualStep) ==
        Approx(kGravity * (1 - 1 / 1.05)).epsilon(0.02));

  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
  }
  REQUIRE(solver.tool_grip(tool).state == GripState::lost);
  CHECK(solver.tool_grip(tool).points.empty());
  const auto momentum = [&] {
    const std::vector<Eigen::Vector3f> velocities = solver.velocities();
    double sum = 0;
    for (Index v = 0; v < solver.vertex_count(); ++v) {
      sum += solver.tissue().masses()[v] * velocities[v].x();
    }
    return sum;
  };
  const double before = momentum();
  solver.step(kUsualStep);
  CHECK((before - momentum()) / slab_mass(solver) == Approx(kGravity * kUsualStep).epsilon(1e-4));
  CHECK(solver.tool_force(tool).norm() == 0);
}

// Would catch tissue that feels another force than the tool tells while it slides: its stretch is
// compared with that of the same slab that is held.
TEST_CASE("grip: a slab that is pulled slips at 2 mu N", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  constexpr float kLimit = 0.3F;
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .damping = 5, .integration = integration});
  const ToolId tool = grasp_slab(solver, slab, HeldSlab::grip(kLimit));
  const double start = mean_of(solver, slab.held()).x();
  const auto is_holding = [&] { return solver.tool_grip(tool).state == GripState::holding; };
  double held_way = 0, held_force = 0;
  pull(solver, tool, 0.4F, [&] {
    REQUIRE(is_holding());
    held_way = mean_of(solver, slab.held()).x() - start;
    held_force = -solver.tool_force(tool).x();
  });
  REQUIRE(held_force > 0.9 * kLimit);
  while (is_holding()) {
    REQUIRE(-solver.tool_force(tool).x() < kLimit);
    held_force = -solver.tool_force(tool).x();
    held_way = mean_of(solver, slab.held()).x() - start;
    pull(solver, tool, kUsualStep, [] {});
  }
  CHECK(held_force > 0.95 * kLimit);
  pull(solver, tool, 0.3F, [] {});
  for (int i = 0; i < 20; ++i) {
    pull(solver, tool, kUsualStep, [] {});
    REQUIRE(solver.tool_grip(tool).state == GripState::slipping);
    CHECK(-solver.tool_force(tool).x() == Approx(kLimit).epsilon(0.01));
    CHECK(solver.tool_grip(tool).slid == Approx(8e-3 * kUsualStep).epsilon(0.5));
  }
  const double slipping_way = mean_of(solver, slab.held()).x() - start;
  CHECK(slipping_way / held_way == Approx(kLimit / held_force).epsilon(0.02));
}

// Would catch multipliers that fraction mode does not clear or scale.
TEST_CASE("grip: the limit holds in fraction mode, too") {
  constexpr float kLimit = 0.02F;
  const HeldSlab slab(true, {.model = ElasticModel::springs, .stretch = {.fraction = 0.3F}});
  Solver solver(slab.scene,
                {.mode = ProjectionMode::fraction, .substeps = 2, .iterations = 10, .damping = 5});
  const ToolId tool = grasp_slab(solver, slab, HeldSlab::grip(kLimit));
  pull(solver, tool, 1, [&] { REQUIRE(solver.tool_force(tool).norm() < 1.5F * kLimit); });
  CHECK(solver.tool_grip(tool).state == GripState::slipping);
  CHECK(solver.tool_force(tool).x() == Approx(-kLimit).epsilon(0.05));
}

// Would catch a clamp force that is read once only, and one of a stiffer copy in other units.
TEST_CASE("grip: jaws that press less hold less, in each copy of any stiffness") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .damping = 5, .copies = 2});
  solver.set_factors({.stiffness = 2}, 1);
  const ToolId tool = solver.add_tool({}, HeldSlab::pose());
  for (const Index copy : {0, 1}) {
    solver.grasp(tool, slab.points(), HeldSlab::grip(1), copy);
  }
  const auto step_both = [&](float way) {
    for (const Index copy : {0, 1}) {
      solver.move_tool(tool, HeldSlab::pose({way, 0, 0}), copy);
    }
    solver.step(kUsualStep);
  };
  for (int i = 1; i <= 60; ++i) {
    step_both(5e-5F * static_cast<float>(i));
  }
  const float soft = solver.tool_grip(tool, 0).pull.x(), stiff = solver.tool_grip(tool, 1).pull.x();
  CHECK(stiff == Approx(2 * soft).epsilon(0.02));
  for (int i = 1; i <= 200; ++i) {  // slowly, so that tissue does not spring back
    for (const Index copy : {0, 1}) {
      solver.set_clamp_force(tool, stiff * (1.05F - 0.75F * static_cast<float>(i) / 200), copy);
    }
    step_both(3e-3F);
  }
  for (const Index copy : {0, 1}) {
    CHECK(solver.tool_grip(tool, copy).state == GripState::slipping);
    CHECK(solver.tool_grip(tool, copy).pull.x() == Approx(0.3 * stiff).epsilon(0.01));
  }
}

// Would catch tissue that tears at another pull than its own, names the wrong vertices or
// tetrahedra, or is still held.
TEST_CASE("grip: tissue tears at its strength times the width of what is held") {
  const SolverMethod method = any_sweeping_method();
  constexpr double kLimit = 0.2, kWidth = 12e-3;
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .damping = 5});
  Grip grip = HeldSlab::grip(1);
  grip.tear_strength = static_cast<float>(kLimit / kWidth);
  const ToolId tool = grasp_slab(solver, slab, grip);
  float last = 0;
  std::ptrdiff_t times_lost = 0;
  pull(solver, tool, 0.6F, [&] {
    const GripReport report = solver.tool_grip(tool);
    times_lost += std::ranges::count(solver.lost_grips(), tool);
    if (report.state == GripState::holding && report.pull.x() > kLimit / 2) {
      CHECK(report.tear_limit == Approx(kLimit).epsilon(0.02));
      last = report.pull.x();
    }
  });
  CHECK(last == Approx(kLimit).epsilon(0.05));
  const GripReport torn = solver.tool_grip(tool);
  REQUIRE(torn.state == GripState::torn);
  CHECK(solver.lost_grips().empty());
  CHECK(times_lost == 1);
  CHECK(torn.points.empty());
  CHECK(torn.torn_vertices == slab.held());
  CHECK(solver.tool_force(tool).norm() == 0);

  REQUIRE(!torn.torn_tets.empty());
  TopologyEdit edit;
  edit.remove_tets = torn.torn_tets;
  solver.tissue().apply(edit);
  for (const Index v : torn.torn_vertices) {
    for (const Index tet : solver.tissue().tets_at(v)) {
      for (const Index corner : solver.tissue().tets()[tet]) {
        CHECK(std::ranges::binary_search(torn.torn_vertices, corner));
      }
    }
  }
  CHECK(solver.tool_grip(tool).torn_tets.empty());
  solver.release(tool);
  CHECK(solver.tool_grip(tool).state == GripState::open);
}

// Would catch points within edges and faces that are held elsewhere, or whose force is not shared
// out by their weights: momentum and moment of the force are the tool's.
TEST_CASE("grip: points of edges and faces of a coarse mesh are held") {
  const SolverMethod method = any_sweeping_method();
  Scene scene;
  scene.set_gravity({0, 0, -kGravity});
  scene.add_body("cube", testing::make_box({1, 1, 1}, 20e-3),
                 {.model = ElasticModel::neo_hookean, .youngs_modulus = 50e3F});
  Solver solver(scene, {.method = method, .damping = 10});
  // of the top: corners 4, 5, 6, 7, diagonal 4 to 7
  const std::vector<TissuePoint> points{{{4, 5, 7}, {0.5F, 0.3F, 0.2F}},
                                        {{7, 4, kInvalidIndex}, {0.5F, 0.5F, 0}},
                                        {{6, kInvalidIndex, kInvalidIndex}, {1, 0, 0}},
                                        {{4, 6, 7}, {0.2F, 0.2F, 0.6F}}};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(10e-3F, 10e-3F, 20e-3F);
  const ToolId tool = solver.add_tool({}, pose);
  Grip grip;
  grip.pad.half_length = grip.pad.half_width = 15e-3F;
  solver.grasp(tool, points, grip);
  for (int i = 0; i < 400; ++i) {
    solver.step(kUsualStep);
  }
  const double weight = slab_mass(solver) * kGravity;
  CHECK(solver.tool_force(tool).z() == Approx(-weight).epsilon(0.002));
  const Eigen::Vector3d arm = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const std::vector<Eigen::Vector3f> positions = solver.positions();
    for (Index v = 0; v < solver.vertex_count(); ++v) {
      sum += solver.tissue().masses()[v] / slab_mass(solver) * positions[v].cast<double>();
    }
    return Eigen::Vector3d(sum - pose.translation().cast<double>());
  }();
  const Eigen::Vector3d torque = arm.cross(Eigen::Vector3d(0, 0, -weight));
  CHECK((solver.tool_torque(tool).cast<double>() - torque).norm() < 0.01 * weight * 10e-3);
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  for (const GraspedPoint& held : solver.tool_grip(tool).points) {
    Eigen::Vector3f x = Eigen::Vector3f::Zero();
    for (int k = 0; k < 3 && held.point.vertices[k] != kInvalidIndex; ++k) {
      x += held.point.weights[k] * positions[held.point.vertices[k]];
    }
    CHECK((pose * held.anchor - x - grip.compliance * held.force).norm() < 5e-6F);
  }
}

// Would catch grips that know of each other's limits or points: one slab between two jaws.
TEST_CASE("grip: two tools hold one slab, and the weaker one slips") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab(false);
  Solver solver(slab.scene, {.method = method, .damping = 5});
  const ToolId strong = grasp_slab(solver, slab, HeldSlab::grip(1));
  std::vector<TissuePoint> others;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    const Eigen::Vector3d& x = slab.scene.positions()[v];
    if (x.x() < 9e-3 && (x.z() < 1e-9 || x.z() > 11.9e-3)) {
      others.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
    }
  }
  constexpr float kWeak = 0.2F;
  const ToolId weak = solver.add_tool({}, HeldSlab::pose({-32e-3F, 0, 0}));
  solver.grasp(weak, others, HeldSlab::grip(kWeak));
  pull(solver, strong, 0.6F, [] {});
  CHECK(solver.tool_grip(strong).state == GripState::holding);
  CHECK(solver.tool_grip(weak).state == GripState::slipping);
  CHECK(solver.tool_force(weak).x() == Approx(kWeak).epsilon(0.01));
  CHECK(solver.tool_force(strong).x() == Approx(-kWeak).epsilon(0.02));
}

// Would catch a grip in which threads race, or whose order they change.
TEST_CASE("grip: the same bits on any number of threads") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab(
      true, {.model = ElasticModel::neo_hookean, .youngs_modulus = 20e3F, .damping = 0.005F});
  const auto run = [&](const Executor& executor) {
    Solver solver(slab.scene, {.method = method, .executor = executor, .math = MathMode::strict});
    const ToolId tool = grasp_slab(solver, slab, HeldSlab::grip(0.1F));
    pull(solver, tool, 0.6F, [] {});
    REQUIRE(solver.tool_grip(tool).state == GripState::slipping);
    const Eigen::Vector3f pull = solver.tool_grip(tool).pull;
    return std::pair(solver.state_hash(), std::array{pull.x(), pull.y(), pull.z()});
  };
  const auto serial = run(executor::serial());
  for (const int threads : {1, 3}) {
    CHECK(run(executor::threads(threads)) == serial);
  }
}

// Would catch points that are held without tissue, or that an undo forgets, and a compaction that
// loses some or holds others.
TEST_CASE("grip: cuts, undo and compaction") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method});
  const ToolId tool = grasp_slab(solver, slab, HeldSlab::grip(1));
  solver.step(kUsualStep);
  const auto at_corner = [&] {
    return std::ranges::count_if(solver.tool_grip(tool).points, [&](const GraspedPoint& held) {
      return held.point.vertices[0] == slab.held().back();
    });
  };
  TopologyEdit edit;
  const auto tets = solver.tissue().tets_at(slab.held().back());
  edit.remove_tets.assign(tets.begin(), tets.end());
  solver.tissue().apply(edit);
  CHECK(at_corner() == 0);
  CHECK(solver.tool_grip(tool).points.size() == slab.held().size() - 1);
  solver.step(kUsualStep);
  solver.tissue().undo();
  CHECK(at_corner() == 1);
  CHECK(solver.tool_grip(tool).points.size() == slab.held().size());

  edit = {};
  const auto at_corner_0 = solver.tissue().tets_at(0);  // it goes, and all get other ids
  edit.remove_tets.assign(at_corner_0.begin(), at_corner_0.end());
  solver.tissue().apply(edit);
  pull(solver, tool, 0.1F, [] {});
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  const GripReport report = solver.tool_grip(tool);
  REQUIRE(report.points.size() == slab.held().size());
  for (std::size_t i = 0; i < report.points.size(); ++i) {
    CHECK(report.points[i].point.vertices[0] == ids.vertices[slab.held()[i]]);
  }
  const float before = report.pull.x();
  pull(solver, tool, kUsualStep, [] {});
  CHECK(solver.tool_grip(tool).pull.x() > before);
}

// Would catch jaws that grasp what they do not squeeze, that push on what they hold, or that hold
// other points than they touched.
TEST_CASE("grip: jaws close around what they squeeze") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .damping = 5});
  constexpr float kRadius = 2e-3F, kHalf = 6e-3F;
  const ToolSurface surface{ContactFeatures::all, 0.3F};
  const auto jaw = [&](float side) {
    std::vector<Capsule> bars;
    for (const float x : {-3e-3F, 0.7e-3F, 4e-3F}) {
      bars.push_back(
          {{x, -8e-3F, side * (kHalf + kRadius)}, {x, 8e-3F, side * (kHalf + kRadius)}, kRadius});
    }
    return bars;
  };
  const ToolId upper = solver.add_tool(jaw(1), HeldSlab::pose(), surface);
  const ToolId lower = solver.add_tool(jaw(-1), HeldSlab::pose(), surface);
  const ToolId holder = solver.add_tool({}, HeldSlab::pose());
  const Grip grip = HeldSlab::grip(1);
  CHECK(solver.close_jaws(holder, {upper, lower}, grip) == 0);
  CHECK(solver.tool_grip(holder).state == GripState::open);
  for (int i = 1; i <= 60; ++i) {
    const float depth = 3e-3F * static_cast<float>(i) / 60;
    solver.move_tool(upper, HeldSlab::pose({0, 0, -depth}));
    solver.move_tool(lower, HeldSlab::pose({0, 0, depth}));
    solver.step(kUsualStep);
  }
  REQUIRE(solver.tool_force(upper).z() > kLeastPinch);
  const std::size_t count = solver.close_jaws(holder, {upper, lower}, grip);
  REQUIRE(count >= 6);
  CHECK(std::ranges::any_of(solver.tool_grip(holder).points, [](const GraspedPoint& held) {
    return held.point.vertices[1] != kInvalidIndex;
  }));
  solver.step(kUsualStep);
  CHECK(solver.tool_force(upper).norm() == 0);
  CHECK(solver.tool_force(lower).norm() == 0);
  const float before = solver.tool_force(holder).x();
  for (int i = 1; i <= 60; ++i) {
    for (const ToolId tool : {upper, lower, holder}) {
      ToolPose pose = solver.tool_pose(tool);
      pose.translation().x() += 2e-3F / 60;
      solver.move_tool(tool, pose);
    }
    solver.step(kUsualStep);
  }
  CHECK(solver.tool_grip(holder).state == GripState::holding);
  CHECK(solver.tool_force(holder).x() < before - 0.1F);
  solver.release(holder);
  solver.step(kUsualStep);
  CHECK(solver.tool_force(upper).z() > 0);
}

// Would catch jaws of one tool that are taken for one side, or go on pushing what they hold.
TEST_CASE("grip: jaws on joints of one tool close around what they squeeze") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .damping = 5});
  constexpr float kRadius = 2e-3F, kHalf = 6e-3F, kArm = 80e-3F;  // m
  std::vector<Capsule> bars;
  for (const float side : {1.0F, -1.0F}) {
    for (const float x : {-3e-3F, 0.7e-3F, 4e-3F}) {
      const float z = side * (kHalf + kRadius);
      bars.push_back({{x, -8e-3F, z}, {x, 8e-3F, z}, kRadius});
    }
  }
  const ToolJoint upper{{kArm, 0, 0}, {0, 1, 0}, 0, 3}, lower{{kArm, 0, 0}, {0, 1, 0}, 3, 3};
  const ToolId tool = solver.add_tool(bars, HeldSlab::pose(), {ContactFeatures::all, 0.3F},
                                      std::array{upper, lower});
  const Grip grip = HeldSlab::grip(1);
  CHECK(solver.close_jaws(tool, {tool, tool}, grip) == 0);
  for (int i = 1; i <= 60; ++i) {
    const float angle = 3e-3F / kArm * static_cast<float>(i) / 60;
    solver.set_joint(tool, 0, -angle);
    solver.set_joint(tool, 1, angle);
    solver.step(kUsualStep);
  }
  const std::size_t count = solver.close_jaws(tool, {tool, tool}, grip);
  REQUIRE(count >= 6);
  int above = 0;
  for (const GraspedPoint& held : solver.tool_grip(tool).points) {
    above += held.anchor.z() > 0 ? 1 : 0;
  }
  CHECK(above >= 3);
  CHECK(count - static_cast<std::size_t>(above) >= 3);
  solver.step(kUsualStep);
  CHECK(solver.tool_contacts(tool).empty());
  const float before = solver.tool_force(tool).x();
  for (int i = 1; i <= 60; ++i) {
    ToolPose pose = solver.tool_pose(tool);
    pose.translation().x() += 2e-3F / 60;
    solver.move_tool(tool, pose);
    solver.step(kUsualStep);
  }
  CHECK(solver.tool_grip(tool).state == GripState::holding);
  CHECK(solver.tool_force(tool).x() < before - 0.1F);
  solver.release(tool);
  solver.step(kUsualStep);
  CHECK_FALSE(solver.tool_contacts(tool).empty());
}

// Would catch a refusal without a reason, or one that has grasped a part.
TEST_CASE("grip: what cannot be held is refused") {
  const HeldSlab slab;
  Solver solver(slab.scene);
  const ToolId tool = solver.add_tool({}, HeldSlab::pose());
  const Grip good = HeldSlab::grip(1);
  const auto refuse = [&](const std::vector<TissuePoint>& points, const Grip& grip,
                          const char* why) {
    CAPTURE(why);
    check_refused([&] { solver.grasp(tool, points, grip); }, why);
    CHECK(solver.tool_grip(tool).state == GripState::open);
  };
  const auto with = [&](const auto& change) {
    Grip grip = good;
    change(grip);
    return grip;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refuse(slab.points(), with([&](Grip& g) { g.clamp_force = -1; }), "clamp force is -1");
  refuse(slab.points(), with([&](Grip& g) { g.friction = nan; }), "friction is nan");
  refuse(slab.points(), with([&](Grip& g) { g.tear_strength = 0; }), "tear strength is 0");
  refuse(slab.points(), with([&](Grip& g) { g.compliance = 0; }), "compliance is 0");
  refuse(slab.points(), with([&](Grip& g) { g.pad.half_width = 0; }), "half width is 0");
  refuse(slab.points(), with([&](Grip& g) { g.pad.center.x() = nan; }), "center is not finite");
  refuse(slab.points(), with([&](Grip& g) { g.pad.normal *= 2; }), "normal has length 2");
  refuse(slab.points(), with([&](Grip& g) { g.pad.along = g.pad.normal; }), "right angle");
  refuse(slab.points(), with([&](Grip& g) { g.pad.half_length = 1e-3F; }), "must be on the pad");

  const auto with_first = [&](const TissuePoint& point) {
    std::vector<TissuePoint> points = slab.points();
    points[0] = point;
    return points;
  };
  const Index v = slab.held()[0];
  refuse(with_first({{-7, kInvalidIndex, kInvalidIndex}, {1, 0, 0}}), good, "has vertex -7");
  refuse(with_first({{kInvalidIndex, kInvalidIndex, kInvalidIndex}, {}}), good, "has no vertex");
  refuse(with_first({{v, kInvalidIndex, v}, {1, 0, 0}}), good, "behind one");
  refuse(with_first({{v, v, kInvalidIndex}, {0.5F, 0.5F, 0}}), good, "twice");
  refuse(with_first({{0, v, kInvalidIndex}, {0.5F, 0.5F, 0}}), good, "no vertex, edge or face");
  refuse(with_first({{v, kInvalidIndex, kInvalidIndex}, {0.5F, 0, 0}}), good, "sum is 0.5");
  refuse(with_first({{v, kInvalidIndex, kInvalidIndex}, {-1, 0, 0}}), good, "weight -1");
  refuse(with_first({{v, kInvalidIndex, kInvalidIndex}, {1, 1, 0}}), good, "of no vertex");
  refuse({slab.points()[0], slab.points()[1]}, good, "three that are not on a line");
  refuse({slab.points()[0], slab.points()[1], slab.points()[2]}, good, "on a line");

  check_refused([&] { solver.set_clamp_force(tool, 1); }, "has no grip");
  const ToolId smooth = solver.add_tool({}, HeldSlab::pose());
  check_refused([&] { solver.close_jaws(tool, {smooth, smooth}, good); }, "has no surface");
  const Capsule bar{{0, 0, 0}, {0, 0, 0}, 1e-3F};
  const ToolId jaw = solver.add_tool({&bar, 1}, HeldSlab::pose(), {ContactFeatures::all, 0});
  check_refused([&] { solver.close_jaws(tool, {jaw, jaw}, good); }, "is both jaws");
  solver.grasp(tool, slab.points(), good);
  check_refused([&] { solver.grasp(tool, slab.points(), good); }, "holds something already");
  check_refused([&] { solver.grasp(tool, std::array<Index, 1>{0}); }, "holds something already");
  check_refused([&] { solver.set_clamp_force(tool, nan); }, "clamp force is nan");

  Solver explicit_solver(slab.scene, {.method = SolverMethod::explicit_steps});
  const ToolId other = explicit_solver.add_tool({}, HeldSlab::pose());
  check_refused([&] { explicit_solver.grasp(other, slab.points(), good); }, "in explicit steps");
}

// Would catch a grip that a device is not told of, goes on with once it has torn, or tells too late
// of: also where an edit takes a point while a step runs.
TEST_CASE("grip: a backend that keeps the state holds, slips and tears alike") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .executor = executor::serial()});
  Solver device(slab.scene, {.method = method, .executor = testing::fake_device()});
  Grip grip = HeldSlab::grip(0.05F);
  grip.tear_strength = 20;
  const ToolId tool = grasp_slab(solver, slab, grip);
  grasp_slab(device, slab, grip);
  const auto compare = [&] {
    const GripReport expected = solver.tool_grip(tool), found = device.tool_grip(tool);
    REQUIRE(found.state == expected.state);
    CHECK(found.pull == expected.pull);
    REQUIRE(found.points.size() == expected.points.size());
    CHECK(device.state_hash() == solver.state_hash());
  };
  const auto pull_both = [&](float time) {
    pull(solver, tool, time, [] {});
    pull(device, tool, time, [] {});
    compare();
  };
  pull_both(0.1F);
  CHECK(solver.tool_grip(tool).state == GripState::slipping);
  TopologyEdit edit;
  const auto tets = solver.tissue().tets_at(slab.held().back());
  edit.remove_tets.assign(tets.begin(), tets.end());
  solver.step(kUsualStep);
  solver.tissue().apply(edit);
  device.start_step(kUsualStep);
  device.tissue().apply(edit);
  static_cast<void>(device.finish_step());
  compare();
  solver.set_clamp_force(tool, 5);
  device.set_clamp_force(tool, 5);
  for (int i = 0; i < 10 && solver.tool_grip(tool).state != GripState::torn; ++i) {
    pull_both(0.05F);
  }
  CHECK(device.tool_grip(tool).state == GripState::torn);
  CHECK(device.lost_grips() == solver.lost_grips());
  pull_both(kUsualStep);
}

}  // namespace pbdsurg
