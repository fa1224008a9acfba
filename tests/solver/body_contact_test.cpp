// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/static_energy.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::any_integration;
using testing::any_sweeping_method;
using testing::Approx;
using testing::ContainsSubstring;
using testing::kUsualStep;
using testing::quick_options;

constexpr double kTableEdge = 5e-3;
constexpr TissueContact kContact{0.5e-3F, 0};
constexpr Material kSoft{.model = ElasticModel::neo_hookean,
                         .youngs_modulus = 20e3F,
                         .poissons_ratio = 0.4F,
                         .damping = 0.01F};

TetMesh moved(const TetMesh& mesh, const Eigen::Vector3d& by) {
  std::vector<Eigen::Vector3d> positions(mesh.positions().begin(), mesh.positions().end());
  for (Eigen::Vector3d& x : positions) {
    x += by;
  }
  return TetMesh(std::move(positions), {mesh.tets().begin(), mesh.tets().end()});
}

// A block that stands fast, and another above it, at a distance, with other edges.
Scene make_stack(double distance, const Vector3f& gravity = {0, 0, -9.81F}) {
  Scene scene;
  scene.set_gravity(gravity);
  const BodyId table = scene.add_body("table", testing::make_box({6, 6, 3}, kTableEdge), kSoft);
  std::vector<Index> bottom;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].z() < 1e-9) {
      bottom.push_back(v);
    }
  }
  scene.fix_vertices(table, bottom);
  scene.add_body("block",
                 moved(testing::make_box({5, 5, 2}, 4e-3), {5e-3, 5e-3, 3 * kTableEdge + distance}),
                 kSoft);
  return scene;
}

struct Sums {
  Vector3f force = Vector3f::Zero();                // N, on body 1
  float least = std::numeric_limits<float>::max();  // m
  int pushing = 0;
};

Sums sum_of(const Solver& solver) {
  Sums sums;
  for (const BodyContact& contact : solver.body_contacts()) {
    sums.force += contact.first == 1 ? contact.force : Vector3f(-contact.force);
    if (contact.force.norm() > 0) {
      sums.least = std::min(sums.least, contact.distance);
      ++sums.pushing;
    }
  }
  return sums;
}

struct TotalMomentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // kg m^2/s
};

TotalMomentum total_momentum(const Solver& solver) {
  const std::vector<Vector3f> x = solver.positions(), v = solver.velocities();
  TotalMomentum sum;
  for (Index i = 0; i < solver.vertex_count(); ++i) {
    const double m = solver.tissue().masses()[i];
    sum.linear += m * v[i].cast<double>();
    sum.angular += m * x[i].cast<double>().cross(v[i].cast<double>());
  }
  return sum;
}

float fastest(const Solver& solver) {
  float most = 0;
  for (const Vector3f& v : solver.velocities()) {
    most = std::max(most, v.norm());
  }
  return most;
}

Vector3f mean(const Solver& solver, Index body) {
  Vector3f sum = Vector3f::Zero();
  const std::vector<Vector3f> x = solver.positions();
  const std::vector<Index> vertices = solver.tissue().vertices_of(body);
  for (const Index v : vertices) {
    sum += x[v];
  }
  return sum / static_cast<float>(vertices.size());
}

// One for projections, whose steps take long.
TimeIntegration integration_of(SolverMethod method) {
  return method == SolverMethod::projection ? TimeIntegration::implicit_euler : any_integration();
}

}  // namespace

// Would catch bodies that fall through each other, sink in, or carry another weight.
TEST_CASE("body contact: a block falls on another and rests there", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  const float press = GENERATE(0.0F, 1.0F);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), press);
  Solver solver(make_stack(2e-3), quick_options(method, integration));
  solver.set_body_contact(1, 0, {kContact.thickness, 0.3F});
  std::vector<Index> top;
  for (const Index v : solver.tissue().vertices_of(1)) {
    if (solver.tissue().rest_positions()[v].z() > 3 * kTableEdge + 2e-3 + 2 * 4e-3 - 1e-9) {
      top.push_back(v);
    }
  }
  const std::vector<Vector3f> forces(top.size(), {0, 0, -press / static_cast<float>(top.size())});
  solver.set_forces(top, forces);

  for (int i = 0; i < 240; ++i) {
    solver.step(kUsualStep);
  }

  const Sums sums = sum_of(solver);
  const float weight = 1000 * 20e-3F * 20e-3F * 8e-3F * 9.81F + press;
  CAPTURE(sums.pushing, fastest(solver));
  CHECK(sums.force.z() == Approx(weight).epsilon(0.02));
  CHECK(std::hypot(sums.force.x(), sums.force.y()) < 0.02F * weight);
  CHECK(kContact.thickness - sums.least < 0.03F * 4e-3F);
  CHECK(fastest(solver) < 2e-3F);  // projections tremble by 1 mm/s
}

// Would catch a force on one side alone, weights that do not sum to zero, or a lever.
TEST_CASE("body contact: two blocks that collide keep their momentum", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  scene.add_body("left", testing::make_box({3, 3, 3}, kTableEdge), kSoft);
  scene.add_body("right", moved(testing::make_box({3, 3, 3}, 4e-3), {16e-3, 5e-3, 3e-3}), kSoft);
  Solver solver(scene, quick_options(method, integration));
  solver.set_body_contact(0, 1, kContact);
  constexpr float kSpeed = 0.05F;
  std::vector<Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                   Vector3f::Zero());
  for (const Index v : solver.tissue().vertices_of(0)) {
    velocities[v] = {kSpeed, 0.005F, 0};
  }
  solver.write_velocities(velocities);
  const TotalMomentum before = total_momentum(solver);
  bool has_met = false;

  for (int i = 0; i < 240; ++i) {
    solver.step(kUsualStep);
    has_met = has_met || sum_of(solver).pushing > 0;
  }

  const TotalMomentum after = total_momentum(solver);
  const double size = before.linear.norm(), moment = 15e-3 * size;
  const bool has_past = integration == TimeIntegration::bdf2;
  REQUIRE(has_met);
  CAPTURE((after.linear - before.linear).norm() / size,
          (after.angular - before.angular).norm() / moment);
  CHECK((after.linear - before.linear).norm() < (has_past ? 1e-4 : 1e-5) * size);
  CHECK((after.angular - before.angular).norm() < (has_past ? 1e-3 : 1e-4) * moment);
  CHECK(mean(solver, 1).x() > 22e-3F + 5e-3F);  // it was pushed
  CHECK(sum_of(solver).pushing == 0);           // and they have parted
}

// Would catch the rebound that backward differences make of a stop, and a push that adds energy.
TEST_CASE("body contact: a block that falls on another gains no energy", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  const bool stands_fast = GENERATE(true, false);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), stands_fast);
  constexpr float kFall = 5e-3F;  // beyond the thickness
  Scene scene = make_stack(kFall + kContact.thickness);
  if (stands_fast) {
    scene.fix_where(0, [](const Eigen::Vector3d& /*x*/) { return true; });
  }
  // few sweeps follow the impact on soft tissue that is held in short steps alone
  const float step = stands_fast ? kUsualStep : 1e-3F;
  Solver solver(scene, quick_options(method, integration));
  solver.set_body_contact(1, 0, {kContact.thickness, 0.3F});
  const bench::StaticEnergy potential(scene);
  const auto energy = [&] {
    bench::Positions positions;
    for (const Vector3f& x : solver.positions()) {
      positions.push_back(x.cast<double>());
    }
    double sum = potential.value(positions);
    const std::vector<Vector3f> v = solver.velocities();
    for (std::size_t i = 0; i < v.size(); ++i) {
      sum += solver.tissue().masses()[i] / 2 * v[i].squaredNorm();
    }
    return sum;
  };
  const double released = 1000 * 20e-3 * 20e-3 * 8e-3 * 9.81 * kFall;
  const double start = energy();
  const float fallen = mean(solver, 1).z() - kFall;
  double most = start;
  float highest = 0;  // of the block, once it has met the other
  bool has_met = false;

  for (int i = 0; i < std::lround(0.15F / step); ++i) {
    solver.step(step);
    most = std::max(most, energy());
    has_met = has_met || sum_of(solver).pushing > 0;
    highest = has_met ? std::max(highest, mean(solver, 1).z()) : highest;
  }

  REQUIRE(has_met);
  CHECK(most - start < 1e-2 * released);
  CHECK(highest - fallen < 0.1F * kFall);
}

// Would catch contacts whose order, or whose partners, hang on who works.
TEST_CASE("body contact: the same bits on any number of threads") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  const auto hash_of = [&](const Executor& executor) {
    SolverOptions options = quick_options(method, integration);
    options.executor = executor;
    options.math = MathMode::strict;
    Solver solver(make_stack(0.6e-3), options);
    solver.set_body_contact(0, 1, {kContact.thickness, 0.2F});
    for (int i = 0; i < 8; ++i) {
      solver.step(kUsualStep);
    }
    REQUIRE(sum_of(solver).pushing > 0);
    return solver.state_hash();
  };
  const std::uint64_t serial = hash_of(executor::serial());
  for (const int threads : {1, 2, 4}) {
    CAPTURE(threads);
    CHECK(hash_of(executor::threads(threads)) == serial);
  }
}

// Would catch overlap that is snapped away: bodies would fly apart.
TEST_CASE("body contact: bodies that overlap from the start part slowly") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Solver solver(make_stack(-0.8e-3, Vector3f::Zero()), quick_options(method, integration));
  solver.set_body_contact(0, 1, kContact);
  const float before = mean(solver, 1).z();
  float most = 0;

  for (int i = 0; i < 100; ++i) {
    solver.step(kUsualStep);
    most = std::max(most, fastest(solver));
  }

  CHECK(most < 0.2F);
  CHECK(mean(solver, 1).z() - before > 0.8e-3F);
  const Sums sums = sum_of(solver);
  CHECK((sums.pushing == 0 || sums.least > 0.9F * kContact.thickness));
}

// Would catch friction that creeps, that does not slide, or that acts on one body alone.
TEST_CASE("body contact: a block on a tilted body sticks or slides by the angle of friction",
          "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  constexpr float kFriction = 0.3F;
  const bool sticks = GENERATE(true, false);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), sticks);
  const float angle = (sticks ? 0.9F : 1.3F) * std::atan(kFriction);
  Solver solver(make_stack(0.5e-3, {0, 0, -9.81F * std::cos(angle)}),
                quick_options(method, integration));
  solver.set_body_contact(0, 1, {kContact.thickness, kFriction});
  for (int i = 0; i < 100; ++i) {
    solver.step(kUsualStep);
  }
  solver.set_gravity({9.81F * std::sin(angle), 0, -9.81F * std::cos(angle)});
  for (int i = 0; sticks && i < 100; ++i) {
    solver.step(kUsualStep);
  }
  const float before = mean(solver, 1).x();
  const int steps = sticks ? 200 : 20;  // it has 5 mm before it overhangs

  for (int i = 0; i < steps; ++i) {
    solver.step(kUsualStep);
  }

  const float time = static_cast<float>(steps) * kUsualStep;
  const float way = 9.81F * (std::sin(angle) - kFriction * std::cos(angle)) / 2 * time * time;
  const float moved = mean(solver, 1).x() - before;
  const Sums sums = sum_of(solver);
  CAPTURE(moved, way, sums.force.x(), sums.force.z());
  if (sticks) {
    CHECK(std::abs(moved) < 0.01F * 4e-3F);
  } else {
    CHECK(moved > 0.85F * way);
    CHECK(moved < 1.2F * way);
    CHECK(-sums.force.x() == Approx(kFriction * sums.force.z()).epsilon(0.03));
  }
}

// Would catch contacts with triangles that are gone, or new ones that throw what they find inside.
TEST_CASE("body contact: a body that is cut while it lies on another stays there") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = integration_of(method);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Solver solver(make_stack(0.5e-3), quick_options(method, integration));
  solver.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 100; ++i) {
    solver.step(kUsualStep);
  }
  REQUIRE(sum_of(solver).pushing > 0);
  const std::uint64_t before = solver.state_hash();
  TopologyEdit edit;
  const std::span<const Tet> tets = solver.tissue().tets();
  for (const Index t : solver.tissue().tets_of(1)) {  // half of what touches
    float low = 1, mid = 0;
    for (const Index v : tets[t]) {
      const Eigen::Vector3d& x = solver.tissue().rest_positions()[v];
      low = std::min(low, static_cast<float>(x.z()));
      mid += static_cast<float>(x.x()) / 4;
    }
    if (low < 3 * kTableEdge + 1e-3 && mid < 11e-3F) {
      edit.remove_tets.push_back(t);
    }
  }
  for (Index t = 0; t < 60; ++t) {  // and some of the table's surface
    edit.remove_tets.push_back(solver.tissue().tets_of(0)[648 - 1 - 7 * t]);
  }
  std::ranges::sort(edit.remove_tets);

  solver.tissue().apply(edit);
  float most = 0;
  for (int i = 0; i < 60; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    most = std::max(most, fastest(solver));
    for (const BodyContact& contact : solver.body_contacts()) {
      for (const Index v : contact.vertices) {
        REQUIRE(solver.tissue().has_tissue(v));
      }
    }
  }
  CHECK(most < 0.5F);
  CHECK(sum_of(solver).pushing > 0);
  CHECK(mean(solver, 1).z() > 3 * kTableEdge - 1e-3F);

  // an undo at once leaves no trace
  Solver other(make_stack(0.5e-3), quick_options(method, integration));
  other.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 100; ++i) {
    other.step(kUsualStep);
  }
  REQUIRE(other.state_hash() == before);
  other.tissue().apply(edit);
  other.tissue().undo();
  CHECK(other.state_hash() == before);
  Solver untouched(make_stack(0.5e-3), quick_options(method, integration));
  untouched.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 120; ++i) {
    untouched.step(kUsualStep);
  }
  for (int i = 0; i < 20; ++i) {
    other.step(kUsualStep);
  }
  CHECK(other.state_hash() == untouched.state_hash());
}

// Would catch a snapshot or a compaction that leaves out which side a vertex is on, or which force
// acts; and searches whose results hang on when they were made.
TEST_CASE("body contact: steps go on after a snapshot as without it") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = integration_of(method);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Solver solver(make_stack(0.5e-3), quick_options(method, integration));
  solver.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 17; ++i) {
    solver.step(kUsualStep);
  }
  REQUIRE(sum_of(solver).pushing > 0);
  Snapshot snapshot = solver.snapshot();
  CHECK(snapshot.body_contacts.size() == solver.body_contacts().size());
  for (int i = 0; i < 30; ++i) {
    solver.step(kUsualStep);
  }
  const std::uint64_t hash = solver.state_hash();

  solver.restore(snapshot);
  for (int i = 0; i < 30; ++i) {
    solver.step(kUsualStep);
  }
  CHECK(solver.state_hash() == hash);

  Solver fresh(make_stack(0.5e-3), quick_options(method, integration));
  fresh.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  snapshot.tissue = fresh.tissue().identified_version();
  fresh.restore(snapshot);
  for (int i = 0; i < 30; ++i) {
    fresh.step(kUsualStep);
  }
  CHECK(fresh.state_hash() == hash);

  const float height = mean(solver, 1).z();
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  for (int i = 0; i < 30; ++i) {
    solver.step(kUsualStep);
  }
  CHECK(sum_of(solver).pushing > 0);
  CHECK(std::abs(mean(solver, 1).z() - height) < 1e-4F);

  Snapshot bad = solver.snapshot();
  bad.body_contacts[0].body = 2;
  CHECK_THROWS_WITH(solver.restore(bad), ContainsSubstring("body 2"));
}

// Would catch bodies that push what links hold together, and a pop where the last link goes.
TEST_CASE("body contact: what links join does not meet until they are gone") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = integration_of(method);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Scene scene = make_stack(0.1e-3, Vector3f::Zero());
  const auto x = [&](Index v) { return scene.positions()[v]; };
  constexpr Index kFirst = 7 * 7 * 4;  // of the block
  for (Index v = kFirst; v < scene.vertex_count(); ++v) {
    if (x(v).z() > 3 * kTableEdge + 1e-3) {
      continue;
    }
    Index nearest = 0;
    for (Index w = 0; w < kFirst; ++w) {
      nearest = (x(w) - x(v)).norm() < (x(nearest) - x(v)).norm() ? w : nearest;
    }
    scene.add_link({nearest, v, static_cast<float>((x(nearest) - x(v)).norm()), {}});
  }
  Solver solver(scene, {.method = method, .integration = integration});
  solver.set_body_contact(0, 1, kContact);
  for (int i = 0; i < 20; ++i) {
    solver.step(kUsualStep);
  }
  CHECK(solver.body_contacts().empty());
  CHECK(fastest(solver) < 1e-5F);

  TopologyEdit edit;
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    edit.remove_links.push_back(l);
  }
  solver.tissue().apply(edit);
  solver.step(kUsualStep);
  CHECK_FALSE(solver.body_contacts().empty());
  CHECK(fastest(solver) > 0.005F);  // they part
  CHECK(fastest(solver) < 0.05F);
  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
  }
  const Sums sums = sum_of(solver);
  CHECK((sums.pushing == 0 || sums.least > 0.9F * kContact.thickness));
}

// Would catch a fold that passes through itself: the arms of a U, bent towards each other.
TEST_CASE("body contact: a body meets itself if it is to", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const bool meets = GENERATE(true, false);
  CAPTURE(static_cast<int>(method), meets);
  constexpr double kCell = 4e-3;
  const TetMesh box = testing::make_box({5, 2, 5}, kCell);
  std::vector<Tet> tets;
  for (const Tet& tet : box.tets()) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Index v : tet) {
      center += box.positions()[v] / 4;
    }
    if (center.z() < kCell || center.x() < 2 * kCell || center.x() > 3 * kCell) {
      tets.push_back(tet);
    }
  }
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  scene.add_body("U", TetMesh({box.positions().begin(), box.positions().end()}, tets), kSoft);
  const auto at = [&](Index v) { return box.positions()[v]; };
  std::vector<Index> fixed, pushed, left, right;
  std::vector<Vector3f> forces;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (at(v).z() < 1e-9) {
      fixed.push_back(v);
    }
    if (at(v).z() > 5 * kCell - 1e-9 && (at(v).x() < 1e-9 || at(v).x() > 5 * kCell - 1e-9)) {
      pushed.push_back(v);
      forces.emplace_back(at(v).x() < 1e-9 ? 0.008F : -0.008F, 0, 0);
    }
    if (at(v).z() > 3 * kCell && std::abs(at(v).x() - 2 * kCell) < 1e-9) {
      left.push_back(v);
    }
    if (at(v).z() > 3 * kCell && std::abs(at(v).x() - 3 * kCell) < 1e-9) {
      right.push_back(v);
    }
  }
  scene.fix_vertices(BodyId(0), fixed);
  Solver solver(scene, quick_options(method));
  if (meets) {
    solver.set_body_contact(0, 0, {kContact.thickness, 0.3F});
  }
  solver.set_forces(pushed, forces);

  for (int i = 0; i < 300; ++i) {
    solver.step(kUsualStep);
  }

  const std::vector<Vector3f> x = solver.positions();
  float gap = 0;  // between the tips, on average
  for (std::size_t i = 0; i < left.size(); ++i) {
    gap += (x[right[i]].x() - x[left[i]].x()) / static_cast<float>(left.size());
  }
  CAPTURE(gap, fastest(solver));
  if (meets) {
    const Sums sums = sum_of(solver);
    CHECK(sums.pushing > 0);
    CHECK(sums.least > 0.95F * kContact.thickness);
    CHECK(gap > 0.8F * kContact.thickness);
    CHECK(gap < 4 * kContact.thickness);
    CHECK(fastest(solver) < 0.01F);
  } else {
    CHECK(gap < -kContact.thickness);
    CHECK(solver.body_contacts().empty());
  }
}

// Would catch a sheet that is met from one side alone, and folds that pass through each other: the
// upper half of a strip falls on the lower one, and a block on both.
TEST_CASE("body contact: a folded sheet carries a block", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  constexpr Index kLong = 12, kWide = 4;
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  for (Index i = 0; i <= kLong; ++i) {  // from the far end of the lower half to that of the upper
    for (Index j = 0; j <= kWide; ++j) {
      const Index from_fold = std::abs(i - kLong / 2);
      points.emplace_back(4e-3 * from_fold, 4e-3 * j, i <= kLong / 2 ? 0 : 1.2e-3 * from_fold);
    }
  }
  for (Index i = 0; i < kLong; ++i) {
    for (Index j = 0; j < kWide; ++j) {
      const Index a = i * (kWide + 1) + j, b = a + kWide + 1;
      triangles.push_back({a, b, b + 1});
      triangles.push_back({a, b + 1, a + 1});
    }
  }
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  const BodyId sheet = scene.add_sheet("sheet", points, triangles, {});
  std::vector<Index> lower;
  for (Index v = 0; v < (kLong / 2) * (kWide + 1); ++v) {
    lower.push_back(v);
  }
  scene.fix_vertices(sheet, lower);
  scene.add_body("block", moved(testing::make_box({2, 2, 2}, 4e-3), {10e-3, 4e-3, 9e-3}), kSoft);
  Solver solver(scene, quick_options(method));
  solver.set_body_contact(0, 0, {kContact.thickness, 0.3F});
  solver.set_body_contact(0, 1, {kContact.thickness, 0.3F});

  for (int i = 0; i < 300; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
  }

  const std::vector<Vector3f> x = solver.positions();
  float lowest = 1;  // of the upper half, beyond the fold
  for (Index v = (kLong / 2 + 2) * (kWide + 1); v < static_cast<Index>(points.size()); ++v) {
    lowest = std::min(lowest, x[v].z());
  }
  float block = 1;
  for (const Index v : solver.tissue().vertices_of(1)) {
    block = std::min(block, x[v].z());
  }
  CAPTURE(lowest, block, fastest(solver));
  CHECK(lowest > 0.9F * kContact.thickness);
  CHECK(block > 1.5F * kContact.thickness);
  CHECK(block < 6e-3F);
  CHECK(fastest(solver) < 0.05F);
}

// Would catch a static obstacle of triangles that tissue sinks into or passes, far from its
// vertices as near them, or that bears another weight.
TEST_CASE("body contact: a block falls into a groove of large triangles that stand fast",
          "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = integration_of(method);
  const float speed = GENERATE(0.0F, 1.0F);  // m/s, downwards, at first
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), speed);
  constexpr double kSide = 60e-3;           // m, of the groove
  constexpr TissueContact kWall{1e-3F, 0};  // m
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  scene.add_body("block", moved(testing::make_box({5, 5, 2}, 4e-3), {-10e-3, -10e-3, 25e-3}),
                 kSoft);
  const std::vector<Eigen::Vector3d> corners{{-kSide, -kSide, kSide}, {-kSide, kSide, kSide},
                                             {0, -kSide, 0},          {0, kSide, 0},
                                             {kSide, -kSide, kSide},  {kSide, kSide, kSide}};
  const std::vector<Triangle> triangles{{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}};
  const BodyId groove = scene.add_sheet("groove", corners, triangles);
  scene.fix_where(groove, [](const Eigen::Vector3d& /*x*/) { return true; });
  Solver solver(scene, {.method = method, .damping = 2, .integration = integration});
  solver.set_body_contact(0, 1, kWall);
  std::vector<Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                   Vector3f::Zero());
  const std::vector<Index> block = solver.tissue().vertices_of(0);
  for (const Index v : block) {
    velocities[v].z() = -speed;
  }
  solver.write_velocities(velocities);
  double mass = 0;
  for (const Index v : block) {
    mass += solver.tissue().masses()[v];
  }
  constexpr int kSteps = 400, kWeighed = 100;
  float least_gap = kInfinity, weight = 0;
  for (int i = 0; i < kSteps; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    const std::vector<Vector3f> x = solver.positions();
    for (const Index v : block) {
      least_gap = std::min(least_gap, (x[v].z() - std::abs(x[v].x())) / std::sqrt(2.0F));
    }
    for (const BodyContact& contact : solver.body_contacts()) {
      const float up = (contact.first == 0 ? 1.0F : -1.0F) * contact.force.z();
      weight += i >= kSteps - kWeighed ? up / kWeighed : 0;
    }
  }
  CHECK(least_gap > 0.5F * kWall.thickness);  // when it falls in
  CHECK(fastest(solver) < 1e-2F);
  CHECK(weight == Approx(9.81 * mass).epsilon(0.02));
}

// Would catch surfaces that cannot take a body that comes, and pairs of one that an undo took.
TEST_CASE("body contact: bodies that come meet those that were there") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  Solver solver(make_stack(0.5e-3), quick_options(method));
  solver.set_body_contact(0, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
  }
  TopologyEdit edit;
  edit.new_bodies.add_body("third",
                           moved(testing::make_box({2, 2, 2}, 4e-3), {11e-3, 11e-3, 24e-3}), kSoft);

  solver.tissue().apply(edit);
  solver.set_body_contact(2, 1, {kContact.thickness, 0.3F});
  solver.step(kUsualStep);
  solver.tissue().undo();
  CHECK_THROWS_WITH(solver.set_body_contact(2, 1, kContact), ContainsSubstring("body 2"));
  solver.step(kUsualStep);
  solver.tissue().apply(edit);
  solver.set_body_contact(2, 1, {kContact.thickness, 0.3F});
  for (int i = 0; i < 160; ++i) {
    solver.step(kUsualStep);
  }

  const float height = mean(solver, 2).z() - mean(solver, 1).z();
  CHECK(height > 7e-3F);
  CHECK(height < 9e-3F);
  CHECK(fastest(solver) < 0.01F);
}

// Would catch input that is taken without a word.
TEST_CASE("body contact: bad input is refused, and nothing is changed") {
  Solver solver(make_stack(1e-3));
  CHECK_THROWS_WITH(solver.set_body_contact(0, 2, kContact), ContainsSubstring("body 2"));
  CHECK_THROWS_WITH(solver.set_body_contact(0, 1, {0, 0}), ContainsSubstring("thickness"));
  CHECK_THROWS_WITH(solver.set_body_contact(0, 1, {1e-3F, -1}), ContainsSubstring("friction"));
  CHECK_THROWS_AS(solver.clear_body_contact(-1, 0), InvalidArgument);
  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
  }
  CHECK(solver.body_contacts().empty());
}

}  // namespace pbdsurg
