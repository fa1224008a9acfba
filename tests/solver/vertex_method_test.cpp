// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/instruction_set.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::farthest;
using testing::kSoftEdge;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;
using testing::soft_springs;
using testing::vertex_options;

Scene make_spring_bar() {
  return make_bar(soft_springs(testing::make_box({8, 3, 3}, kSoftEdge, 0.1)));
}

}  // namespace

TEST_CASE("vertex method: tissue comes to rest where projections bring it", "[validation]") {
  const bool springs = GENERATE(true, false);
  const Scene scene = springs ? make_spring_bar() : make_bar(neo_hookean(2e4F, 0.4F));
  Solver vertices(scene, vertex_options(4, 30, 20));
  Solver projections(scene,
                     testing::small_steps({.substeps = 20, .iterations = 15, .damping = 20}));
  const auto start = projections.positions();

  run(vertices, 150);
  run(projections, 150);

  const auto sag = start.back().y() - projections.positions().back().y();
  REQUIRE(sag > 0.2 * kSoftEdge);  // something to agree on
  CHECK(farthest(vertices, projections) < 0.01F * sag);
}

// rho g L^2 / (2 E), the stretch of a bar under its own weight
TEST_CASE("vertex method: a Neo-Hookean bar hangs as long as its modulus says", "[validation]") {
  const double length = 16 * kSoftEdge;
  const float youngs_modulus = 20000;
  Scene scene = make_bar(neo_hookean(youngs_modulus, 0.3F), {16, 3, 3});
  scene.set_gravity({9.81F, 0, 0});
  Solver solver(scene, vertex_options(1, 200, 20));
  double before = 0;
  for (const Eigen::Vector3f& p : solver.positions()) {
    before = std::max<double>(before, p.x());
  }

  const StepReport report = run(solver, 100, 0.02F);

  double after = 0;
  for (const Eigen::Vector3f& p : solver.positions()) {
    after = std::max<double>(after, p.x());
  }
  const double expected = 1000 * 9.81 * length * length / (2 * youngs_modulus);
  CHECK(after - before == Approx(expected).epsilon(0.05));
  CHECK(report.inverted_tets == 0);
}

// What rests needs no sweep to stay, and what falls needs none to fall.
TEST_CASE("vertex method: a free body falls as it should, in one sweep", "[validation]") {
  Scene scene;
  scene.add_body("block", testing::make_box({3, 3, 3}, kSoftEdge, 0.1), neo_hookean(1e5F, 0.45F));
  scene.set_gravity({0, 0, -9.81F});
  Solver solver(scene, vertex_options(5));
  const float before = solver.positions()[7].z();

  run(solver, 10, 0.01F);

  CHECK(before - solver.positions()[7].z() == Approx(9.81 * 4e-6 * 50 * 51 / 2).epsilon(1e-3));
}

TEST_CASE("vertex method: equal runs give equal bits, and a snapshot replays", "[golden]") {
  Material material = neo_hookean(2e4F, 0.45F);
  material.damping = GENERATE(0.0F, 1e-3F);
  const Scene scene = make_bar(material);
  Solver first(scene, vertex_options(3, 2));
  Solver second(scene, vertex_options(3, 2));
  run(first, 10);
  run(second, 10);
  CHECK(first.state_hash() == second.state_hash());

  const Snapshot snapshot = first.snapshot();
  run(first, 5);
  const std::uint64_t after = first.state_hash();
  run(first, 3);
  first.restore(snapshot);
  CHECK(first.state_hash() == second.state_hash());
  run(first, 5);
  CHECK(first.state_hash() == after);

  Snapshot wrong = snapshot;
  wrong.falling[3] = -1;
  CHECK_THROWS_WITH(first.restore(wrong), ContainsSubstring("must be in [0, 1]"));
  wrong.falling.pop_back();
  CHECK_THROWS_AS(first.restore(wrong), InvalidArgument);
  wrong = snapshot;
  wrong.roundings[2].y() = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH(first.restore(wrong), ContainsSubstring("rounding of vertex 2"));
}

// All that a step can meet: both models, damping, links, stiff ones, too, contacts, grasps, edits,
// a lost vertex.
TEST_CASE("vertex method: the same bits on any number of threads, and the serial ones if strict",
          "[golden]") {
  const TetMesh mesh = testing::make_box({9, 6, 5}, kSoftEdge, 0.1);
  Material soft = neo_hookean(2e4F, 0.45F);
  soft.damping = GENERATE(0.0F, 5e-4F);
  const auto coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  Scene scene;
  scene.add_body("liver", mesh, soft);
  scene.add_body("duct", testing::make_box({4, 2, 2}, kSoftEdge, 0.1, 2), soft_springs(mesh));
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.y() < 0.5 * kSoftEdge; });
  for (Index v = 0; v < 5; ++v) {
    scene.add_link({v + 60, scene.body(1).first_vertex + v, 1e-3F, {1, 0.05F}});
  }
  // stiff ones: several at some vertices, one of them fixed, some where a tool holds, some of no
  // length
  std::vector<Eigen::Vector3d> clips;
  for (Index v = 0; v < 20; ++v) {
    const Index a = 402 - v % 17, b = scene.body(1).first_vertex + 20 + v % 12;
    const auto length = static_cast<float>((scene.positions()[a] - scene.positions()[b]).norm());
    scene.add_link({a, b, length, {1, v % 4 == 0 ? 0 : 1e-6F}});
    clips.push_back(scene.positions()[a]);
  }
  clips.push_back(scene.positions()[0]);
  const BodyId clip = scene.add_particles("clips", clips, 1e-5);
  for (Index v = 0; v < 20; ++v) {
    scene.add_link({402 - v % 17, scene.body(clip).first_vertex + v, 0, {1, 0}});
  }
  REQUIRE(scene.is_fixed(0));
  scene.add_link({0, scene.body(clip).first_vertex + 20, 0, {1, 0}});
  const auto after = [&](const Executor& executor, MathMode math) {
    SolverOptions options = vertex_options(3, 2);
    options.executor = executor;
    options.math = math;
    options.over_relaxation = 1.2F;
    options.coarse_correction = coarse_correction;
    Solver solver(scene, options);
    const float top = 6.2F * static_cast<float>(kSoftEdge);
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0.012F, top + 0.006F, 0.01F);
    const ToolId tool =
        solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0.01F, 0, 0}, 0.006F}}, pose);
    const ToolId grasper = solver.add_tool({}, ToolPose::Identity());
    solver.grasp(grasper, std::vector<Index>{400, 401, 402}, 1e-3F);
    solver.grasp(grasper, std::vector<Index>{410});
    std::vector<Eigen::Vector3f> velocities(solver.positions().size(), Eigen::Vector3f::Zero());
    velocities.back().setConstant(std::numeric_limits<float>::max());
    for (int i = 0; i < 12; ++i) {
      pose.translation().y() -= 3e-4F;
      solver.move_tool(tool, pose);
      if (i == 4) {
        solver.tissue().apply({.remove_tets = {100, 101, 500, 700}, .remove_links = {2, 9}});
      }
      if (i == 8) {
        CHECK(solver.tool_force(tool).norm() > 0);
        CHECK(solver.tool_force(grasper).norm() > 0);
        solver.write_velocities(velocities);
        solver.step(10.0F);
      }
      solver.step(2e-3F);
    }
    // a number that is none has bits of no meaning
    std::uint64_t hash = 0;
    for (const Eigen::Vector3f& x : solver.positions()) {
      for (const float value : {x.x(), x.y(), x.z()}) {
        hash =
            hash * 1099511628211U + (std::isnan(value) ? 1 : std::bit_cast<std::uint32_t>(value));
      }
    }
    return hash;
  };

  const std::string set = GENERATE("AVX-512", "AVX2", "SSSE3");
  const testing::InstructionSet only(set);
  const std::uint64_t serial = after(executor::serial(), MathMode::fast);
  const std::uint64_t fast = after(executor::threads(1), MathMode::fast);
  for (const int threads : {1, 2, 3, 5}) {
    CHECK(after(executor::threads(threads), MathMode::strict) == serial);
    CHECK(after(executor::threads(threads), MathMode::fast) == fast);
  }
}

// Would catch idle lanes that move the vertex which they repeat: here all blocks have some.
TEST_CASE("vertex method: a held vertex is moved once, wherever it lies in its block", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, kSoftEdge), neo_hookean(2e4F, 0.4F));
  const auto after = [&](const Executor& executor, Index held) {
    SolverOptions options = vertex_options(2, 2);
    options.executor = executor;
    options.math = MathMode::strict;
    Solver solver(scene, options);
    const ToolId tool = solver.add_tool({}, ToolPose::Identity());
    solver.grasp(tool, std::vector<Index>{held}, 1e-2F);
    run(solver, 3);
    return solver.state_hash();
  };
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    CHECK(after(executor::threads(2), v) == after(executor::serial(), v));
  }
}

TEST_CASE("vertex method: over-relaxation brings few sweeps closer to many", "[property]") {
  Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {12, 3, 3});
  const auto after = [&](int iterations, float over_relaxation) {
    SolverOptions options = vertex_options(4, iterations);
    options.over_relaxation = over_relaxation;
    Solver solver(scene, options);
    run(solver, 20);
    return solver;
  };
  const Solver converged = after(300, 1);

  CHECK(farthest(after(6, 1.6F), converged) < 0.7F * farthest(after(6, 1), converged));
}

TEST_CASE("vertex method: inner friction ends a vibration and lets a turn go on", "[validation]") {
  const bool springs = GENERATE(false, true);
  const TetMesh mesh =
      testing::make_box({4, 2, 2}, kSoftEdge);  // symmetric: its growth turns nothing
  Material material = springs ? soft_springs(mesh) : neo_hookean(2e4F, 0.4F);
  const auto speed_after = [&](float damping, bool turns) {
    material.damping = damping;
    Scene scene;
    scene.add_body("block", mesh, material);
    scene.set_gravity(Eigen::Vector3f::Zero());
    Solver solver(scene, vertex_options(20, 10));
    const Eigen::Vector3f centre(2 * kSoftEdge, kSoftEdge, kSoftEdge);
    std::vector<Eigen::Vector3f> velocities;
    for (const Eigen::Vector3f& x : solver.positions()) {
      const Eigen::Vector3f arm = x - centre;
      velocities.emplace_back(turns ? Eigen::Vector3f(Eigen::Vector3f(0, 0, 5).cross(arm))
                                    : Eigen::Vector3f(20 * arm));
    }
    solver.write_velocities(velocities);
    double before = 0, after = 0;
    for (const Eigen::Vector3f& u : solver.velocities()) {
      before += u.squaredNorm();
    }
    run(solver, 20, 1e-3F);
    for (const Eigen::Vector3f& u : solver.velocities()) {
      after += u.squaredNorm();
    }
    return std::sqrt(after / before);
  };

  CHECK(speed_after(1e-3F, false) < 0.2 * speed_after(0, false));
  CHECK(speed_after(1e-3F, true) > 0.98 * speed_after(0, true));
}

TEST_CASE("vertex method: a body pressed flat or turned inside out recovers", "[validation]") {
  const float factor = GENERATE(0.0F, -0.3F);
  Scene scene = make_bar(neo_hookean(2e4F, 0.4F), {6, 3, 3});
  scene.set_gravity(Eigen::Vector3f::Zero());
  SolverOptions options = vertex_options(2, 10, 20);
  options.coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  Solver solver(scene, options);
  const auto rest = solver.positions();
  auto x = rest;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (!scene.is_fixed(v)) {
      x[v].x() *= factor;
    }
  }
  solver.write_positions(x);

  const StepReport report = run(solver, 400);

  CHECK(report.inverted_tets == 0);
  float distance = 0;
  const auto now = solver.positions();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    distance = std::max(distance, (now[v] - rest[v]).norm());
  }
  CHECK(distance < 0.02F * static_cast<float>(kSoftEdge));
}

TEST_CASE("vertex method: a vertex that is lost takes nothing else along", "[unit]") {
  const bool springs = GENERATE(false, true);
  Scene scene = springs ? make_spring_bar() : make_bar(neo_hookean(2e4F, 0.4F));
  Solver solver(scene, vertex_options(2, 2));
  std::vector<Eigen::Vector3f> velocities(solver.positions().size(), Eigen::Vector3f::Zero());
  velocities.back().setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);

  StepReport report = solver.step(10.0F);
  CHECK(report.non_finite_vertices == 1);
  report = run(solver, 20);

  CHECK(report.non_finite_vertices == 1);
  CHECK(report.first_non_finite == scene.vertex_count() - 1);
}

TEST_CASE("vertex method: its plan has colours of vertices alone", "[unit]") {
  Scene scene = make_bar(neo_hookean(2e4F, 0.4F));
  Solver solver(scene, vertex_options());
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, std::vector<Index>{30});

  CHECK(solver.plan().phases.size() >= 4);
  CHECK(solver.plan().phases.size() <= 9);
  for (const Phase& phase : solver.plan().phases) {
    CHECK(phase.kind == PhaseKind::vertex);
    CHECK_FALSE(phase.serial);
  }
  CHECK(solver.plan().name.find("greedy by saturation+repair+search, vertices") !=
        std::string::npos);
  const Solver plain(scene, [] {
    SolverOptions options = vertex_options();
    options.coloring.repair = false;
    return options;
  }());
  CHECK(plain.plan().name.find("greedy by saturation, vertices") != std::string::npos);
}

TEST_CASE("vertex method: what it cannot follow is refused by name", "[unit]") {
  const TetMesh mesh = testing::make_box({1, 1, 1}, kSoftEdge);
  const auto build = [&](const Material& material, SolverOptions options) {
    Scene scene;
    scene.add_body("liver", mesh, material);
    return Solver(scene, options);
  };
  Material material = soft_springs(mesh);
  SolverOptions options = vertex_options();
  CHECK_NOTHROW(build(material, options));

  options.mode = ProjectionMode::fraction;
  CHECK_THROWS_WITH(build(material, options), ContainsSubstring("fraction"));
  options = vertex_options();
  options.composition = PlanComposition::joint;
  CHECK_THROWS_WITH(build(material, options), ContainsSubstring("joint"));
  options = vertex_options();
  options.coloring.max_colors = 3;
  CHECK_THROWS_WITH(build(material, options), ContainsSubstring("max_colors is 3"));
  for (const float wrong : {0.9F, 2.0F, std::numeric_limits<float>::quiet_NaN()}) {
    options = vertex_options();
    options.over_relaxation = wrong;
    CHECK_THROWS_WITH(build(material, options), ContainsSubstring("over_relaxation"));
  }

  material.stretch.compliance = 0;
  CHECK_THROWS_WITH(build(material, vertex_options()),
                    ContainsSubstring("'liver': stretch compliance is 0"));
  material = soft_springs(mesh);
  material.volume.compliance = 0;
  CHECK_THROWS_WITH(build(material, vertex_options()), ContainsSubstring("volume compliance"));
  material.has_volume_constraints = false;
  CHECK_NOTHROW(build(material, vertex_options()));
}

}  // namespace pbdsurg
