// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/solver.h"

#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;

// A bar along x, by default free and without gravity.
Scene make_bar_of_springs(bool fixed = false, std::array<Index, 3> cells = {8, 3, 3}) {
  Scene scene;
  scene.add_body("bar", testing::make_box(cells, kSoftEdge, 0.1), testing::kSprings);
  scene.set_gravity(Eigen::Vector3f::Zero());
  if (fixed) {
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  }
  return scene;
}

std::vector<Eigen::Vector3f> stretched(const Solver& solver, float factor) {
  std::vector<Eigen::Vector3f> x = solver.positions();
  for (Eigen::Vector3f& p : x) {
    p.x() *= factor;
  }
  return x;
}

}  // namespace

TEST_CASE("solver: both modes pull a stretched bar back to rest", "[property]") {
  const auto options = GENERATE(SolverOptions::paper(), testing::small_steps({.damping = 5}));
  const Scene scene = make_bar_of_springs(true);
  Solver solver(scene, options);
  const std::vector<Eigen::Vector3f> rest = solver.positions();
  std::vector<Eigen::Vector3f> start = stretched(solver, 1.1F);
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    start[v] = scene.is_fixed(v) ? rest[v] : start[v];  // or there would be no way back
  }
  solver.write_positions(start);

  StepReport report;
  for (int i = 0; i < 300; ++i) {
    report = solver.step(5e-3F);
  }

  float farthest = 0;
  const std::vector<Eigen::Vector3f> now = solver.positions();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    farthest = std::max(farthest, (now[v] - rest[v]).norm());
  }
  CHECK(farthest < 1e-3 * kSoftEdge);
  CHECK(report.distance_residual < 1e-4F);
  CHECK(report.volume_residual < 1e-4F);
  CHECK(report.inverted_tets == 0);
  CHECK(report.non_finite_vertices == 0);
}

// Would catch any force without its reaction, in either mode.
TEST_CASE("solver: a free body keeps its linear momentum", "[property]") {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  const Scene scene = make_bar_of_springs();
  Solver solver(scene, testing::small_steps({.mode = mode, .substeps = 4, .iterations = 3}));
  solver.write_positions(stretched(solver, 1.2F));
  for (int i = 0; i < 3; ++i) {
    solver.step(1e-3F);
  }

  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double scale = 0;
  const auto velocities = solver.velocities();
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    const Eigen::Vector3d p = scene.masses()[v] * velocities[v].cast<double>();
    momentum += p;
    scale += p.norm();
  }
  REQUIRE(scale > 0);
  CHECK(momentum.norm() < 1e-4 * scale);
}

TEST_CASE("solver: a spinning body keeps its angular momentum", "[property]") {
  const Scene scene = make_bar_of_springs();
  Solver solver(scene, testing::small_steps({.substeps = 10, .iterations = 4}));
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double mass = 0;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    centre += scene.masses()[v] * scene.positions()[v];
    mass += scene.masses()[v];
  }
  centre /= mass;
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3d& x : scene.positions()) {
    velocities.push_back(Eigen::Vector3d(0, 0, 20).cross(x - centre).cast<float>());
  }
  solver.write_velocities(velocities);
  const auto angular_momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const auto x = solver.positions();
    const auto u = solver.velocities();
    for (std::size_t v = 0; v < x.size(); ++v) {
      sum += scene.masses()[v] * (x[v].cast<double>() - centre).cross(u[v].cast<double>());
    }
    return sum;
  };
  const Eigen::Vector3d before = angular_momentum();

  for (int i = 0; i < 100; ++i) {
    solver.step(1e-3F);
  }

  // the chord of a turn by omega h loses (omega h)^2 of it a substep, 0.4 % in all
  CHECK((angular_momentum() - before).norm() < 0.01 * before.norm());
}

TEST_CASE("solver: a free body falls as it should", "[unit]") {
  Scene scene = make_bar_of_springs();
  scene.set_gravity({0, 0, -9.81F});
  Solver solver(scene, testing::small_steps({.substeps = 5}));
  const float before = solver.positions()[7].z();

  for (int i = 0; i < 10; ++i) {
    solver.step(0.01F);
  }

  // symplectic Euler over n substeps of h: g h^2 n (n + 1) / 2
  CHECK(before - solver.positions()[7].z() == Approx(9.81 * 4e-6 * 50 * 51 / 2).epsilon(1e-3));
}

// Would catch a preferred direction in forces, contacts or prediction.
TEST_CASE("solver: a rotated scene moves alike", "[property]") {
  const Eigen::Matrix3f rotation =
      Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, -2, 3).normalized()).toRotationMatrix();
  const auto run = [&](const Eigen::Matrix3f& frame) {
    const TetMesh bar = testing::make_box({8, 3, 3}, kSoftEdge, 0.1);
    std::vector<Eigen::Vector3d> points;
    for (const Eigen::Vector3d& p : bar.positions()) {
      points.push_back(frame.cast<double>() * p);
    }
    Scene scene;
    scene.add_body("bar", TetMesh(points, {bar.tets().begin(), bar.tets().end()}),
                   testing::kSprings);
    std::vector<Index> rim;
    for (Index v = 0; v < bar.vertex_count(); ++v) {
      if (bar.positions()[v].x() < 0.5 * kSoftEdge) {
        rim.push_back(v);
      }
    }
    scene.fix_vertices(0, rim);
    scene.set_gravity(frame * Eigen::Vector3f(0, -9.81F, 0));
    Solver solver(scene, testing::small_steps());
    for (int i = 0; i < 20; ++i) {
      solver.step(5e-3F);
    }
    return solver.positions();
  };
  const auto straight = run(Eigen::Matrix3f::Identity());
  const auto turned = run(rotation);

  float farthest = 0;
  for (std::size_t v = 0; v < straight.size(); ++v) {
    farthest = std::max(farthest, (turned[v] - rotation * straight[v]).norm());
  }
  CHECK(farthest < 1e-2F * static_cast<float>(kSoftEdge));
}

TEST_CASE("solver: fixed vertices stay, exactly", "[unit]") {
  Scene scene = make_bar_of_springs(true);
  scene.set_gravity({0, -9.81F, 0});
  Solver solver(scene, testing::small_steps());
  const auto before = solver.positions();
  for (int i = 0; i < 10; ++i) {
    solver.step(0.01F);
  }
  const auto after = solver.positions();
  Index fixed = 0;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.is_fixed(v)) {
      CHECK(after[v] == before[v]);
      ++fixed;
    }
  }
  CHECK(fixed == 16);
}

TEST_CASE("solver: equal runs give equal bits, and a snapshot replays", "[golden]") {
  const SolverOptions options =
      GENERATE(testing::small_steps(), SolverOptions::paper(),
               testing::small_steps({.iterations = 2, .composition = PlanComposition::joint}));
  Scene scene = make_bar_of_springs(true);
  scene.set_gravity({0, -9.81F, 0});
  Solver first(scene, options), second(scene, options);
  for (int i = 0; i < 5; ++i) {
    first.step(0.01F);
    second.step(0.01F);
  }
  CHECK(first.state_hash() == second.state_hash());

  const Snapshot snapshot = first.snapshot();
  first.step(0.01F);
  const std::uint64_t after = first.state_hash();
  CHECK(after != second.state_hash());
  first.restore(snapshot);
  CHECK(first.state_hash() == second.state_hash());
  first.step(0.01F);
  CHECK(first.state_hash() == after);
}

// The paper's figure 9: a dragged organ is near its rest shape 100 ms after release.
TEST_CASE("solver: a dragged block recovers within 100 ms", "[validation]") {
  Solver solver(make_bar_of_springs(true, {8, 5, 5}), testing::small_steps({.damping = 40}));
  const auto rest = solver.positions();
  std::vector<Index> tip;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    if (rest[v].x() > 7.5F * static_cast<float>(kSoftEdge)) {
      tip.push_back(v);
    }
  }
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, tip);
  ToolPose pulled = ToolPose::Identity();
  for (int i = 1; i <= 40; ++i) {
    pulled.translation() = Eigen::Vector3f(0, 0.01F * static_cast<float>(i) / 40, 0);
    solver.move_tool(tool, pulled);
    solver.step(5e-3F);
  }
  const auto away = [&] { return (solver.positions()[tip[0]] - rest[tip[0]]).norm(); };
  CHECK(away() == Approx(0.01).epsilon(0.01));

  solver.release(tool);
  for (int i = 0; i < 20; ++i) {
    solver.step(5e-3F);
  }

  CHECK(away() < 0.2 * 0.01);
}

TEST_CASE("solver: inverted tetrahedra and overflow are reported, not thrown", "[unit]") {
  Solver solver(make_bar_of_springs(),
                testing::small_steps({.mode = ProjectionMode::fraction, .substeps = 1}));
  std::vector<Eigen::Vector3f> mirrored = solver.positions();
  for (Eigen::Vector3f& p : mirrored) {
    p.x() = -p.x();
  }
  solver.write_positions(mirrored);
  CHECK(solver.step(1e-4F).inverted_tets > 0);

  // one vertex leaves the range of numbers; it takes nothing else along
  std::vector<Eigen::Vector3f> velocities(mirrored.size(), Eigen::Vector3f::Zero());
  velocities.back().setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);
  const StepReport report = solver.step(10);
  CHECK(report.non_finite_vertices == 1);
  CHECK(report.first_non_finite == solver.vertex_count() - 1);
  CHECK(std::isinf(report.distance_residual));
  CHECK(std::isinf(report.volume_residual));
}

// Would catch a force that is no number, which no device must be given.
TEST_CASE("solver: a lost vertex pulls no tool", "[unit]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float compliance = GENERATE(0.0F, 1e-4F);
  Scene scene;
  const TetMesh box = testing::make_box({3, 2, 2}, kSoftEdge);
  scene.add_body("box", box, elastic_material(box, 1000, 2e4));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  Solver solver(scene,
                testing::small_steps({.method = method, .substeps = 2, .executor = executor}));
  std::vector<Eigen::Vector3f> velocities(solver.positions().size(), Eigen::Vector3f::Zero());
  velocities.back().setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);
  REQUIRE(solver.step(10).non_finite_vertices == 1);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const Index last = solver.vertex_count() - 1;
  solver.grasp(tool, std::array{Index{last - 1}, last}, compliance);

  solver.step(1e-3F);

  CHECK(solver.tool_force(tool).allFinite());
  CHECK(solver.tool_force(tool).norm() > 0);
}

TEST_CASE("solver: tubes without volume constraints can be inverted too", "[unit]") {
  Scene scene;
  scene.add_body("tube", testing::make_box({1, 1, 1}, kSoftEdge),
                 {.model = ElasticModel::springs, .has_volume_constraints = false});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps());
  auto mirrored = solver.positions();
  for (Eigen::Vector3f& p : mirrored) {
    p.x() = -p.x();
  }
  solver.write_positions(mirrored);
  CHECK(solver.step(1e-3F).inverted_tets == 6);
}

TEST_CASE("solver: an elastic material is softer where the modulus is lower", "[property][long]") {
  const TetMesh bar = testing::make_box({8, 3, 3}, kSoftEdge);
  const auto sag = [&](double modulus, int substeps) {
    Scene scene;
    scene.add_body("bar", bar, elastic_material(bar, 1000, modulus));
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
    Solver solver(scene,
                  testing::small_steps({.substeps = substeps, .iterations = 10, .damping = 20}));
    for (int i = 0; i < 300; ++i) {
      solver.step(5e-3F);
    }
    return static_cast<double>(scene.positions()[8].y() - solver.positions()[8].y());
  };
  const double soft = sag(20e3, 20);
  CHECK(soft > 1e-4);
  CHECK(soft / sag(40e3, 20) == Approx(2).epsilon(0.1));
  CHECK(soft / sag(20e3, 40) == Approx(1).epsilon(0.1));  // stiffness is not left to the steps

  CHECK_THROWS_WITH(elastic_material(bar, 1000, 0), ContainsSubstring("Young's modulus"));
  CHECK_THROWS_WITH(elastic_material(bar, 1000, 1e3, 0.5), ContainsSubstring("Poisson's ratio"));
  CHECK_THROWS_WITH(elastic_material(TetMesh(), 1000, 1e3), ContainsSubstring("tetrahedra"));
}

TEST_CASE("solver: the plan lists every phase once and colours are valid in size", "[unit]") {
  Solver solver(make_bar_of_springs(), testing::small_steps());
  Index distances = 0, volumes = 0;
  for (const Phase& phase : solver.plan().phases) {
    distances += phase.kind == PhaseKind::distance;
    volumes += phase.kind == PhaseKind::volume;
  }
  CHECK(distances + volumes == static_cast<Index>(solver.plan().phases.size()));
  CHECK(distances >= 14);  // the valence of an inner vertex of this lattice: edges, tetrahedra
  CHECK(volumes >= 24);
}

TEST_CASE("solver: partial readback gives what was asked for", "[unit]") {
  const Solver solver(make_bar_of_springs(), testing::small_steps());
  const auto all = solver.positions();
  const std::vector<Index> some{5, 0, 17};
  std::vector<Eigen::Vector3f> out(3);

  solver.read_positions(some, out);

  CHECK(out[0] == all[5]);
  CHECK(out[2] == all[17]);
  CHECK_THROWS_WITH(solver.read_positions(std::vector<Index>{100000}, std::span(out).first(1)),
                    ContainsSubstring("no vertex 100000"));
  CHECK_THROWS_AS(solver.read_positions(some, std::span(out).first(2)), InvalidArgument);
}

TEST_CASE("solver: bad arguments are refused by name", "[unit]") {
  const Scene scene = make_bar_of_springs();
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.substeps = -1})),
                    ContainsSubstring("substeps is -1"));
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.iterations = -3})),
                    ContainsSubstring("iterations is -3"));
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.damping = -1})),
                    ContainsSubstring("damping"));
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.contact_capacity = -1})),
                    ContainsSubstring("capacity"));
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.mode = static_cast<ProjectionMode>(7)})),
                    ContainsSubstring("mode 7"));

  Solver solver(scene, testing::small_steps());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float dt : {0.0F, -1.0F, nan, std::numeric_limits<float>::infinity()}) {
    CHECK_THROWS_AS(solver.step(dt), InvalidArgument);
  }
  auto x = solver.positions();
  x[4].y() = nan;
  CHECK_THROWS_WITH(solver.write_positions(x), ContainsSubstring("vertex 4"));
  CHECK_THROWS_AS(solver.write_positions(std::span(x).first(3)), InvalidArgument);
  CHECK_THROWS_WITH(solver.tissue().is_tet_alive(-1), ContainsSubstring("no tet -1"));
  CHECK_THROWS_WITH(solver.tool_force(ToolId{0}), ContainsSubstring("no tool 0"));
  CHECK_THROWS_WITH(
      solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {1, 0, 0}, 0}}, ToolPose::Identity()),
      ContainsSubstring("capsule 0"));
  CHECK_THROWS_WITH(solver.step(1e-25F), ContainsSubstring("substep"));
  ToolPose scaled = ToolPose::Identity();
  scaled.linear() *= 2;
  CHECK_THROWS_WITH(solver.add_tool({}, scaled), ContainsSubstring("rotation"));
  Snapshot other = solver.snapshot();
  const std::uint64_t before = solver.state_hash();
  other.positions[0].x() += 1;
  other.velocities[5].x() = nan;
  CHECK_THROWS_WITH(solver.restore(other), ContainsSubstring("velocity of vertex 5"));
  CHECK(solver.state_hash() == before);
  other = solver.snapshot();
  other.tissue.number = 9;
  CHECK_THROWS_WITH(solver.restore(other), ContainsSubstring("topology version 9"));
  CHECK_THROWS_WITH(
      solver.restore(Solver(make_bar_of_springs(), testing::small_steps()).snapshot()),
      ContainsSubstring("another tissue"));
}

// Would catch a product of compliance and 1 / substep^2 that overflows: then nothing is a number.
TEST_CASE("solver: the largest compliance resists nothing, however short the substep", "[unit]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  Scene scene;
  const TetMesh box = testing::make_box({2, 2, 2}, kSoftEdge);
  scene.add_body("box", box,
                 {.model = ElasticModel::springs,
                  .stretch = {1, kLargestCompliance},
                  .volume = {1, kLargestCompliance}});
  Solver solver(scene, testing::small_steps({.substeps = 1, .executor = executor}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const Index vertex = 0;
  solver.grasp(tool, {&vertex, 1}, kLargestCompliance);
  CHECK(solver.step(1e-12F).non_finite_vertices == 0);
  CHECK(solver.tool_force(tool).allFinite());
  CHECK_THROWS_WITH(solver.step(1e-14F), ContainsSubstring("substep"));
  CHECK_THROWS_WITH(solver.grasp(tool, std::vector<Index>{1}, 2 * kLargestCompliance),
                    ContainsSubstring("[0, 1e12]"));
  const std::vector<Eigen::Vector3f> before = solver.positions();

  const StepReport report = solver.step(0.1F);

  CHECK(report.non_finite_vertices == 0);
  const Eigen::Vector3f fall(0, -9.81F * 0.1F * 0.1F, 0);
  CHECK((solver.positions().back() - before.back() - fall).norm() < 1e-4F);
}

TEST_CASE("solver: an empty scene steps", "[unit]") {
  Solver solver(Scene{}, testing::small_steps());
  CHECK(solver.step(0.01F).non_finite_vertices == 0);
  CHECK(solver.vertex_count() == 0);
}

}  // namespace pbdsurg
