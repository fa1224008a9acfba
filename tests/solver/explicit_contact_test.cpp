// SPDX-License-Identifier: Apache-2.0
// Bodies that meet each other in explicit steps.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using Eigen::Affine3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::Approx;
using testing::gravity_on;
using testing::kBlockCells;
using testing::kBlockEdge;
using testing::kBlockMass;
using testing::kContactThickness;
using testing::kGravity;
using testing::kUsualStep;
using testing::mean_of;
using testing::placed_box;
using testing::run;

SolverOptions dragged_options(float drag) {
  return {.method = SolverMethod::explicit_steps, .damping = drag};
}

Material elastic() {
  Material material = testing::tissue();
  material.damping = 0;
  return material;
}

// A block as those of free_block.h, and below it a body that stands fast.
Scene make_block_on_table() {
  Scene scene;
  scene.add_body(
      "block",
      placed_box(kBlockCells, kBlockEdge, Affine3d(Translation3d(0, 0, kContactThickness))),
      elastic());
  const BodyId table = scene.add_body(
      "table", placed_box({10, 4, 1}, 20e-3, Affine3d(Translation3d(-20e-3, -20e-3, -20e-3))),
      elastic());
  scene.fix_where(table, [](const Vector3d& /*x*/) { return true; });
  scene.set_gravity({0, 0, -kGravity});
  return scene;
}

Vector3d block_of(const Solver& solver) {
  return mean_of(solver, 0, static_cast<Index>(solver.tissue().vertices_of(0).size()));
}

// N, on the block.
Vector3d force_on_block(const Solver& solver) {
  Vector3d sum = Vector3d::Zero();
  for (const BodyContact& contact : solver.body_contacts()) {
    sum += (contact.first == 0 ? 1.0 : -1.0) * contact.force.cast<double>();
  }
  return sum;
}

Vector3d linear_momentum(const Solver& solver) {
  const std::vector<Vector3f> v = solver.velocities();
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) {
    sum += solver.tissue().masses()[i] * v[i].cast<double>();
  }
  return sum;
}

}  // namespace

// Would catch bodies that fall through each other, sink in, or carry another weight.
TEST_CASE("explicit contact: a block rests on a body with its weight", "[validation]") {
  Solver solver(make_block_on_table(), dragged_options(60));
  solver.set_body_contact(0, 1, {kContactThickness, 0.3F});
  run(solver, kUsualStep, 1);

  Vector3d force = Vector3d::Zero();
  for (int i = 0; i < 100; ++i) {
    solver.step(kUsualStep);
    force += force_on_block(solver) / 100;
  }

  CHECK(force.z() == Approx(kBlockMass * kGravity).epsilon(0.01));
  float lowest = 1;
  for (const Index v : solver.tissue().vertices_of(0)) {
    lowest = std::min(lowest, solver.positions()[v].z());
  }
  CHECK(lowest > 0.99F * kContactThickness);
  CHECK(lowest < 1.01F * kContactThickness);
}

// Would catch friction that creeps, or that does not slide as Coulomb's does.
TEST_CASE("explicit contact: a block on a tilted body stays or slides by the angle of friction",
          "[validation]") {
  const float share = GENERATE(0.9F, 1.3F);
  CAPTURE(share);
  constexpr float kFriction = 0.3F;
  const float slope = share * std::atan(kFriction);
  Scene scene = make_block_on_table();
  scene.set_gravity(gravity_on(slope).cwiseProduct(Vector3f::UnitZ()));
  Solver solver(scene, dragged_options(0));
  solver.set_body_contact(0, 1, {kContactThickness, kFriction});
  run(solver, kUsualStep, 0.5F);
  solver.set_gravity(gravity_on(slope));
  if (share < 1) {
    run(solver, kUsualStep, 0.2F);
  }
  const double before = block_of(solver).x();

  Vector3d force = Vector3d::Zero();
  for (int i = 0; i < 100; ++i) {
    solver.step(kUsualStep);
    force += force_on_block(solver) / 100;
  }

  const double gone = block_of(solver).x() - before;
  if (share < 1) {
    CHECK(std::abs(gone) < 0.01 * kBlockEdge);
  } else {
    const double way = kGravity * (std::sin(slope) - kFriction * std::cos(slope)) / 2 * 0.25;
    CHECK(gone == Approx(way).epsilon(0.05));
    CHECK(-force.x() == Approx(kFriction * force.z()).epsilon(0.02));
  }
}

// Would catch a force on one side alone, and weights that do not sum to zero.
TEST_CASE("explicit contact: two bodies that collide keep their momentum", "[validation]") {
  Scene scene;
  scene.add_body("block", placed_box(kBlockCells, kBlockEdge, Affine3d::Identity()), elastic());
  scene.add_body("other", placed_box({3, 3, 3}, 4e-3, Affine3d(Translation3d(21e-3, 5e-3, -3e-3))),
                 elastic());
  scene.set_gravity(Vector3f::Zero());
  Solver solver(scene, dragged_options(0));
  solver.set_body_contact(0, 1, {kContactThickness, 0.4F});
  std::vector<Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                   Vector3f::Zero());
  for (const Index v : solver.tissue().vertices_of(0)) {
    velocities[v] = {0.2F, 0.1F, 0.02F};
  }
  solver.write_velocities(velocities);
  const Vector3d before = linear_momentum(solver);
  bool has_met = false;

  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
    has_met = has_met || force_on_block(solver).norm() > 0;
    REQUIRE((linear_momentum(solver) - before).norm() < 1e-4 * before.norm());
  }
  CHECK(has_met);
  CHECK(mean_of(solver, static_cast<Index>(solver.tissue().vertices_of(0).size())).x() > 30e-3);
}

// Would catch contacts that one thread finds or answers while others move their vertices.
TEST_CASE("explicit contact: any number of threads has the serial bits", "[determinism]") {
  const auto hash = [&](const Executor& executor) {
    SolverOptions options = dragged_options(0);
    options.executor = executor;
    options.math = MathMode::strict;
    Solver solver(make_block_on_table(), options);
    solver.set_body_contact(0, 1, {kContactThickness, 0.3F});
    for (int i = 0; i < 10; ++i) {
      solver.step(kUsualStep);
    }
    REQUIRE(!solver.body_contacts().empty());
    return solver.state_hash();
  };
  const std::uint64_t serial = hash(executor::serial());
  for (const int threads : {1, 2, 4}) {
    CAPTURE(threads);
    CHECK(hash(executor::threads(threads)) == serial);
  }
}

}  // namespace pbdsurg
