// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/renumbering.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::inspect;

constexpr double kStripEdge = 5e-3;  // m, also the thickness
constexpr float kRigidity = 1e-3F;   // N m; that of the solid is a twentieth
constexpr float kLowGravity = 2;     // m/s^2
constexpr Index kStripCells = 8;

// Clamped by its first column of cells.
Scene make_clamped_strip(float rigidity, float damping = 0) {
  const TetMesh mesh = testing::make_box({kStripCells, 2, 1}, kStripEdge);
  Scene scene;
  scene.add_body("strip", mesh,
                 {.density = 1000,
                  .model = ElasticModel::neo_hookean,
                  .youngs_modulus = 5e3F,
                  .poissons_ratio = 0.3F,
                  .damping = damping});
  if (rigidity > 0) {
    scene.add_hinges(0, rigidity);
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1.1 * kStripEdge; });
  scene.set_gravity({0, 0, -kLowGravity});
  return scene;
}

// m, once it rests.
double sag(const Scene& scene, SolverOptions options) {
  options.substeps = options.method == SolverMethod::projection ? 20 : 4;
  options.iterations = options.method == SolverMethod::projection ? 2 : 30;
  options.damping = 20;
  options.executor = executor::serial();
  Solver solver(scene, options);
  for (int i = 0; i < 200; ++i) {
    REQUIRE(solver.step(5e-3F).non_finite_vertices == 0);
  }
  double lowest = 0;
  const auto positions = solver.positions();
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    lowest = std::max(lowest, scene.positions()[v].z() - double{positions[v].z()});
  }
  return lowest;
}

Scene make_bent_bodies(float damping) {
  const TetMesh plate = testing::make_box({7, 6, 1}, kStripEdge, 0.1);
  Scene scene;
  scene.add_body("plate", plate, {.model = ElasticModel::neo_hookean, .damping = damping});
  Material springs = elastic_material(plate, 1000, 2e4);
  springs.damping = damping;
  springs.max_stretch = 1.2F;
  scene.add_body("net", plate, springs);
  scene.add_hinges(0, 1e-3F);
  scene.add_hinges(1, 1e-4F);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kStripEdge; });
  scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.y() < 0.5 * kStripEdge; });
  return scene;
}

}  // namespace

// Would catch a stiffness that is not that of a plate: two faces of rigidity D each, and the solid.
TEST_CASE("bending: a hinged strip sags as its faces' rigidity says, by either method",
          "[unit][long]") {
  // the hinges at the clamp turn for half a cell on either side
  const double length = (kStripCells - 0.5) * kStripEdge;
  const double load = 1000 * kLowGravity * kStripEdge;  // Pa
  const double of_faces = load * std::pow(length, 4) / (8 * 2 * kRigidity);
  const double projected = sag(make_clamped_strip(kRigidity), {.method = SolverMethod::projection});
  const double by_vertices =
      sag(make_clamped_strip(kRigidity), {.method = SolverMethod::vertex_block});
  const double of_solid = sag(make_clamped_strip(0), {.method = SolverMethod::projection});
  CAPTURE(of_faces, projected, by_vertices, of_solid);
  CHECK(projected < of_solid / 3);
  CHECK(projected > 0.92 * of_faces);
  CHECK(projected < 1.02 * of_faces);
  CHECK(std::abs(by_vertices - projected) < 0.03 * projected);
}

TEST_CASE("bending: registers and threads give the serial bits", "[equivalence]") {
  const float damping = GENERATE(0.0F, 2e-3F);
  const Scene scene = make_bent_bodies(damping);
  const int variant = GENERATE(0, 1, 2, 3, 4);
  SolverOptions options =
      testing::small_steps({.substeps = 3, .iterations = 2, .math = MathMode::strict});
  options.composition = PlanComposition::separate;
  switch (variant) {
    case 1:
      options.composition = PlanComposition::joint;
      break;
    case 2:
      options.composition = PlanComposition::nested;
      break;
    case 3:
      options.coloring.max_colors = 6;
      break;
    case 4:
      options.method = SolverMethod::vertex_block;
      break;
  }
  options.executor = executor::serial();
  Solver serial(scene, options);
  const bool has_phase = std::ranges::any_of(
      serial.plan().phases, [](const Phase& phase) { return phase.kind == PhaseKind::bending; });
  CHECK(has_phase == (options.method == SolverMethod::projection));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(serial.step(5e-3F).non_finite_vertices == 0);
  }
  for (const int threads : {1, 2, 3}) {
    options.executor = executor::threads(threads);
    Solver threaded(scene, options);
    for (int i = 0; i < 20; ++i) {
      threaded.step(5e-3F);
    }
    CHECK(threaded.state_hash() == serial.state_hash());
  }
}

// Would catch damping that turns a hinge while all of it turns, or that adds up tangents.
TEST_CASE("bending: a damped hinge at rest resists no rigid motion", "[unit]") {
  Scene scene;
  const TetMesh box = testing::make_box({2, 2, 1}, kStripEdge, 0.1);
  scene.add_body("box", box, {.model = ElasticModel::neo_hookean, .damping = 1});
  scene.add_hinges(0, 1e-2F);
  scene.set_gravity({0, 0, 0});
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(
      scene, {.method = method, .substeps = 20, .iterations = 8, .executor = executor::serial()});
  const Eigen::Vector3f spin(0, 0, 3);  // rad/s
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : solver.positions()) {
    velocities.push_back(spin.cross(x));
  }
  solver.write_velocities(velocities);
  const auto energy = [&] {
    double sum = 0;
    const auto now = solver.velocities();
    for (std::size_t v = 0; v < now.size(); ++v) {
      sum += scene.masses()[v] * now[v].squaredNorm();
    }
    return sum;
  };
  const double before = energy();
  for (int i = 0; i < 10; ++i) {
    solver.step(5e-3F);
  }
  CHECK(energy() > 0.9 * before);
}

TEST_CASE("bending: fraction mode refuses hinges, and edits that bring some", "[unit]") {
  Scene scene;
  const TetMesh box = testing::make_box({1, 1, 1}, kStripEdge);
  scene.add_body("box", box, testing::kSprings);
  TopologyEdit edit;
  edit.new_bodies.add_body("guest", box, testing::kSprings);
  edit.new_bodies.add_hinges(0, 1e-3F);
  SolverOptions options =
      testing::small_steps({.mode = ProjectionMode::fraction, .executor = executor::serial()});
  Solver solver(scene, options);
  CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring("18 hinges"));
  CHECK(solver.tissue().hinges().empty());
  scene.add_hinges(0, 1e-3F);
  CHECK_THROWS_WITH(Solver(scene, options), ContainsSubstring("compliance mode"));

  Tissue gone(scene);  // hinges that there were
  gone.apply({.remove_tets = {0}});
  CHECK_THROWS_WITH(Solver(gone, options), ContainsSubstring("hinges"));
  edit = {.remove_bodies = {0}};
  edit.new_bodies.add_body("other", box, testing::kSprings);
  gone.apply(edit);
  CHECK_NOTHROW(Solver(gone, options));
}

// Would catch hinges that a compaction drops, mixes up or takes back to rest.
TEST_CASE("bending: a compaction keeps the hinges that live", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(
      make_bent_bodies(1e-3F),
      testing::small_steps({.method = method, .substeps = 4, .executor = executor::serial()}));
  TopologyEdit edit{.remove_tets = {3, 40, 41, 300}};
  edit.new_bodies.add_body("guest", testing::make_box({2, 2, 1}, kStripEdge, 0.1),
                           {.model = ElasticModel::neo_hookean});
  edit.new_bodies.add_hinges(0, 1e-3F);
  solver.tissue().apply(edit);
  REQUIRE(!solver.tissue().last_change().removed_hinges.empty());
  for (int i = 0; i < 3; ++i) {
    solver.step(5e-3F);
  }
  const std::vector<Hinge> before(solver.tissue().hinges().begin(), solver.tissue().hinges().end());
  std::vector<HingeNumbers> numbers;
  for (std::size_t h = 0; h < before.size(); ++h) {
    numbers.push_back(inspect(solver).sets.numbers_of_hinge(static_cast<Index>(h)));
  }
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  REQUIRE(ids.hinges.size() == before.size());
  Index next = 0;
  for (std::size_t h = 0; h < before.size(); ++h) {
    if (!numbers[h]) {
      CHECK(ids.hinges[h] == kInvalidIndex);
      continue;
    }
    REQUIRE(ids.hinges[h] == next++);
    CHECK(solver.tissue().is_hinge_alive(ids.hinges[h]));
    CHECK(inspect(solver).sets.numbers_of_hinge(ids.hinges[h]) == numbers[h]);
    for (std::size_t k = 0; k < 4; ++k) {
      const Index v = ids.vertices[before[h].vertices[k]];
      CHECK(solver.tissue().hinges()[ids.hinges[h]].vertices[k] == v);
      CHECK(std::ranges::count(solver.tissue().hinges_at(v), ids.hinges[h]) == 1);
    }
  }
  CHECK(next == static_cast<Index>(solver.tissue().hinges().size()));
  CHECK(next < static_cast<Index>(before.size()));
  CHECK(solver.step(5e-3F).non_finite_vertices == 0);
}

// Would catch phases, groups or rows that a scene pays for without hinges.
TEST_CASE("bending: a scene without hinges has nothing of them", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Solver solver(make_clamped_strip(0),
                      testing::small_steps({.method = method, .executor = executor::serial()}));
  const SolverData& data = inspect(solver);
  CHECK(data.sets.of<BendingConstraint>().memory_bytes() == 0);
  CHECK(std::ranges::count(data.sets.phases, PhaseKind::bending, &Phase::kind) == 0);
  CHECK(data.vertex_blocks.arrays().hinges.empty());
}

}  // namespace pbdsurg
