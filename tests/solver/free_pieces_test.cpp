// SPDX-License-Identifier: Apache-2.0
// Momentum of what nothing holds, with vertex blocks.
#include "lib/solver/methods/free_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_data.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::neo_hookean;
using testing::run;
using testing::vertex_options;

constexpr double kPieceEdge = 5e-3;

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // kg m^2/s, about the centre of mass
};

Momentum momentum_of(const Solver& solver, const std::vector<Index>& vertices) {
  const auto x = solver.positions();
  const auto v = solver.velocities();
  const auto masses = solver.tissue().masses();
  double mass = 0;
  Momentum sum;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Index i : vertices) {
    mass += masses[i];
    sum.linear += masses[i] * v[i].cast<double>();
    centre += masses[i] * x[i].cast<double>();
  }
  centre /= mass;
  for (const Index i : vertices) {
    sum.angular += masses[i] * (x[i].cast<double>() - centre).cross(v[i].cast<double>().eval());
  }
  return sum;
}

std::vector<Index> all_vertices(const Solver& solver) {
  std::vector<Index> vertices;
  for (Index v = 0; v < solver.tissue().vertex_count(); ++v) {
    if (solver.tissue().has_tissue(v)) {
      vertices.push_back(v);
    }
  }
  return vertices;
}

void add_block(Scene& scene, const Material& material, const Eigen::Vector3d& at,
               std::array<Index, 3> cells = {6, 6, 6}) {
  const TetMesh mesh = testing::make_box(cells, kPieceEdge);
  std::vector<Eigen::Vector3d> positions(mesh.positions().begin(), mesh.positions().end());
  for (Eigen::Vector3d& x : positions) {
    x += at;
  }
  scene.add_body("block " + std::to_string(scene.bodies().size()),
                 TetMesh(positions, {mesh.tets().begin(), mesh.tets().end()}), material);
}

// Sets all free vertices spinning around an axis through their centre, while they drift.
void spin(Solver& solver, const Eigen::Vector3f& rate, const Eigen::Vector3f& drift) {
  const auto x = solver.positions();
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& p : x) {
    centre += p / static_cast<float>(x.size());
  }
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& p : x) {
    velocities.push_back(drift + rate.cross(p - centre));
  }
  solver.write_velocities(velocities);
}

Scene weightless() {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

Index free_count(Solver& solver) {
  SolverData& data = solver_data(solver);
  data.free_pieces.refresh(*data.tissue, data.place_of_vertex);
  return data.free_pieces.count();
}

}  // namespace

// Would catch sweeps that end early and give a free body a push: up to 30 % over these two seconds.
TEST_CASE("free piece: a spinning body keeps its momentum, whatever the sweeps", "[validation]") {
  struct Case {
    float youngs_modulus, rate, dt;
  };
  const auto [youngs_modulus, rate, dt] =
      GENERATE(Case{1e4F, 6.3F, 5e-3F}, Case{1e5F, 6.3F, 5e-3F}, Case{2.5e5F, 6.3F, 5e-3F},
               Case{1e4F, 2, 5e-3F}, Case{2.5e5F, 2, 5e-3F}, Case{1e5F, 6.3F, 1e-3F});
  SolverOptions options = GENERATE(SolverOptions{}, vertex_options(1, 10), vertex_options(2, 3));
  if (options.iterations == 3) {
    options.over_relaxation = 1.7F;
    options.coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  }
  CAPTURE(youngs_modulus, rate, dt, options.substeps, options.iterations);
  Scene scene = weightless();
  add_block(scene, neo_hookean(youngs_modulus, 0.45F), {0.1, 0, 0});
  Solver solver(scene, options);
  spin(solver, {0.3F * rate, 0.8F * rate, -0.5F * rate}, {0.05F, 0.08F, -0.06F});
  const Momentum before = momentum_of(solver, all_vertices(solver));

  run(solver, static_cast<int>(std::lround(2 / dt)), dt);

  const Momentum after = momentum_of(solver, all_vertices(solver));
  CHECK((after.linear - before.linear).norm() < 0.005 * before.linear.norm());
  CHECK((after.angular - before.angular).norm() < 0.02 * before.angular.norm());
}

// Would catch pieces whose sums mix, and links between free bodies that push them.
TEST_CASE("free piece: two bodies keep their own momenta, linked ones their sum", "[validation]") {
  const float compliance = GENERATE(-1.0F, 1e-2F, 1e-6F);  // none, soft, stiff
  CAPTURE(compliance);
  Scene scene = weightless();
  add_block(scene, neo_hookean(2e4F, 0.4F), {0, 0, 0}, {4, 3, 3});
  add_block(scene, neo_hookean(1e5F, 0.4F), {0.02, 0, 0}, {3, 3, 3});
  const Index first_count = scene.bodies()[0].vertex_count;
  std::vector<Index> first, second;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    (v < first_count ? first : second).push_back(v);
  }
  for (const Index a : first) {
    for (const Index b : second) {
      const double way = (scene.positions()[a] - scene.positions()[b]).norm();
      if (compliance > 0 && way < 1e-6) {
        scene.add_link({a, b, static_cast<float>(way), {1, compliance}});
      }
    }
  }
  Solver solver(scene, vertex_options(1, 10));
  REQUIRE(free_count(solver) == (compliance > 0 ? 1 : 2));
  spin(solver, {3, -2, 4}, {0.05F, 0.08F, -0.06F});
  const auto linear = [&](const std::vector<Index>& vertices) {
    return momentum_of(solver, vertices).linear;
  };
  const Eigen::Vector3d before = linear(first), before_second = linear(second);
  const Momentum all_before = momentum_of(solver, all_vertices(solver));

  run(solver, 200);

  const Momentum all = momentum_of(solver, all_vertices(solver));
  CHECK((all.linear - all_before.linear).norm() < 0.005 * all_before.linear.norm());
  CHECK((all.angular - all_before.angular).norm() < 0.02 * all_before.angular.norm());
  if (compliance < 0) {
    CHECK((linear(first) - before).norm() < 0.005 * before.norm());
    CHECK((linear(second) - before_second).norm() < 0.005 * before_second.norm());
  }
}

// Would catch lists that stay as they were before an edit, its undo or a compaction.
TEST_CASE("free piece: follows cuts, undo, links, new bodies and compactions", "[unit]") {
  Scene scene = weightless();
  add_block(scene, neo_hookean(2e4F, 0.4F), {0, 0, 0}, {7, 2, 2});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  scene.add_particles("thread", std::vector<Eigen::Vector3d>{{0, 0.1, 0}, {0, 0.11, 0}}, 1e-3);
  scene.add_link({scene.vertex_count() - 2, scene.vertex_count() - 1, 0.01F, {1, 0.1F}});
  Solver solver(scene, vertex_options(1, 5));
  CHECK(free_count(solver) == 1);  // the thread
  std::vector<Index> slice;
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
    double x = 0;
    for (const Index v : scene.tets()[t]) {
      x += scene.positions()[v].x() / 4;
    }
    if (x > 2 * kPieceEdge && x < 3 * kPieceEdge) {
      slice.push_back(t);
    }
  }
  solver.tissue().apply({.remove_tets = slice});
  CHECK(free_count(solver) == 2);
  solver.tissue().undo();
  CHECK(free_count(solver) == 1);
  solver.tissue().apply({.remove_tets = slice});
  const Index far = scene.bodies()[0].vertex_count - 1;

  // the part that came off spins on
  std::vector<Index> part;
  for (Index v = 0; v < scene.bodies()[0].vertex_count; ++v) {
    if (scene.positions()[v].x() > 2.5 * kPieceEdge) {
      part.push_back(v);
    }
  }
  spin(solver, {2, 3, 5}, {0.05F, 0.08F, -0.06F});
  const Momentum before = momentum_of(solver, part);
  run(solver, 200);
  const Momentum after = momentum_of(solver, part);
  CHECK((after.linear - before.linear).norm() < 0.005 * before.linear.norm());
  CHECK((after.angular - before.angular).norm() < 0.02 * before.angular.norm());

  solver.tissue().apply({.new_links = {{far, 0, 0.1F, {1, 0.1F}}}});  // to a fixed vertex
  CHECK(free_count(solver) == 1);
  solver.tissue().undo();
  CHECK(free_count(solver) == 2);
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  CHECK(free_count(solver) == 2);
  TopologyEdit edit;
  edit.new_bodies.add_body("new", testing::make_box({2, 2, 2}, kPieceEdge),
                           neo_hookean(2e4F, 0.4F));
  solver.tissue().apply(edit);
  CHECK(free_count(solver) == 3);
}

// Would catch a correction that takes off what a tool gives, or goes on without it afterwards.
TEST_CASE("free piece: what a tool pushes keeps all of the push", "[validation]") {
  Scene scene = weightless();
  add_block(scene, neo_hookean(5e4F, 0.4F), {0, 0, 0}, {4, 4, 4});
  Solver solver(scene, vertex_options(1, 5));
  Solver untouched(scene, vertex_options(1, 5));
  static_cast<void>(solver_data(untouched).free_pieces.leave());  // without the operation
  const float dt = 2e-3F;
  const auto step = [&](Solver& each, float height) {
    ToolPose pose = ToolPose::Identity();
    pose.translation().y() = height;
    each.move_tool(ToolId{0}, pose);
    return each.step(dt).contacts;
  };
  for (Solver* each : {&solver, &untouched}) {
    each->add_tool(std::vector<Capsule>{{{0.01F, 0, 0.01F}, {0.01F, 0, 0.01F}, 4e-3F}},
                   ToolPose::Identity());
  }
  for (int i = 0; i < 50; ++i) {  // upwards, faster and faster
    const float height = -3.95e-3F + 4e-6F * static_cast<float>(i * i);
    REQUIRE(step(solver, height) > 0);
    REQUIRE(step(untouched, height) > 0);
    REQUIRE(solver.state_hash() == untouched.state_hash());
  }
  const Eigen::Vector3d pushed = momentum_of(solver, all_vertices(solver)).linear;
  REQUIRE(pushed.y() > 1e-4);
  for (int i = 0; i < 200; ++i) {
    step(solver, -0.1F);
  }
  CHECK((momentum_of(solver, all_vertices(solver)).linear - pushed).norm() < 1e-3 * pushed.norm());
}

// Would catch a correction of what hangs on something held, directly or by others.
TEST_CASE("free piece: what links hold is not free", "[unit]") {
  Scene scene;
  add_block(scene, neo_hookean(2e4F, 0.4F), {0, 0, 0}, {2, 2, 2});
  add_block(scene, neo_hookean(2e4F, 0.4F), {0.02, 0, 0}, {2, 2, 2});
  add_block(scene, neo_hookean(2e4F, 0.4F), {0.04, 0, 0}, {2, 2, 2});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  const float compliance = GENERATE(1e-2F, 1e-6F);
  scene.add_link({20, 30, 0.01F, {1, compliance}});
  scene.add_link({50, 60, 0.01F, {1, compliance}});
  Solver solver(scene, vertex_options(1, 5));
  Solver without(scene, vertex_options(1, 5));
  static_cast<void>(solver_data(without).free_pieces.leave());
  const auto are_alike = [&](int steps) {
    run(solver, steps);
    run(without, steps);
    return solver.state_hash() == without.state_hash();
  };
  CHECK(free_count(solver) == 0);
  CHECK(are_alike(20));
  for (Solver* each : {&solver, &without}) {
    each->tissue().apply({.remove_links = {1}});
  }
  CHECK(free_count(solver) == 1);
  CHECK_FALSE(are_alike(20));
  solver.tissue().apply({.remove_links = {0}});
  CHECK(free_count(solver) == 2);
}

// Would catch sums that depend on who takes which piece.
TEST_CASE("free piece: threads have the serial bits, with lost vertices, too", "[property]") {
  Scene scene;
  add_block(scene, neo_hookean(2e4F, 0.4F), {0, 0, 0}, {7, 7, 7});
  add_block(scene, neo_hookean(1e5F, 0.4F), {0.1, 0, 0}, {3, 3, 3});
  add_block(scene, neo_hookean(1e5F, 0.4F), {0.2, 0, 0}, {1, 1, 1});
  SolverOptions options = vertex_options(2, 3);
  options.math = MathMode::strict;
  options.composition = PlanComposition::separate;
  options.executor = executor::serial();
  Solver serial(scene, options);
  std::vector<Solver> others;
  for (const int threads : {1, 2, 3}) {
    options.executor = executor::threads(threads);
    others.emplace_back(scene, options);
  }
  spin(serial, {3, -2, 4}, {0.05F, 0.08F, -0.06F});
  std::vector<Eigen::Vector3f> velocities = serial.velocities();
  if (GENERATE(false, true)) {
    velocities[40].x() = 1e30F;
  }
  serial.write_velocities(velocities);
  for (Solver& other : others) {
    other.write_velocities(velocities);
  }
  for (int i = 0; i < 30; ++i) {
    serial.step(5e-3F);
    for (Solver& other : others) {
      other.step(5e-3F);
      REQUIRE(other.state_hash() == serial.state_hash());
    }
  }
  CHECK(std::isfinite(serial.velocities().back().x()));
}

}  // namespace pbdsurg
