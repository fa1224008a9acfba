// SPDX-License-Identifier: Apache-2.0
// Free bodies on other bodies, by vertex blocks: how they rest, stick, slide and share momentum.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
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
using testing::any_integration;
using testing::Approx;
using testing::gravity_on;
using testing::kBlockCells;
using testing::kBlockEdge;
using testing::kBlockMass;
using testing::kContactThickness;
using testing::kGravity;
using testing::kUsualStep;
using testing::make_free_block;
using testing::placed_box;
using testing::run;
using testing::tissue;
using testing::vertex_blocks;

// m, on average over its vertices.
Vector3d mean_of_body(const Solver& solver, Index body) {
  const std::vector<Vector3f> x = solver.positions();
  const std::vector<Index> vertices = solver.tissue().vertices_of(body);
  Vector3d sum = Vector3d::Zero();
  for (const Index v : vertices) {
    sum += x[v].cast<double>();
  }
  return sum / static_cast<double>(vertices.size());
}

// kg m/s
Vector3d momentum_of_body(const Solver& solver, Index body) {
  const std::vector<Vector3f> v = solver.velocities();
  Vector3d sum = Vector3d::Zero();
  for (const Index i : solver.tissue().vertices_of(body)) {
    sum += solver.tissue().masses()[i] * v[i].cast<double>();
  }
  return sum;
}

// N, on a body by another.
Vector3d force_between(const Solver& solver, Index on, Index by) {
  Vector3d sum = Vector3d::Zero();
  for (const BodyContact& contact : solver.body_contacts()) {
    if (contact.first == on && contact.second == by) {
      sum += contact.force.cast<double>();
    } else if (contact.first == by && contact.second == on) {
      sum -= contact.force.cast<double>();
    }
  }
  return sum;
}

void give_velocity(Solver& solver, Index body, const Vector3f& velocity) {
  std::vector<Vector3f> all = solver.velocities();
  for (const Index v : solver.tissue().vertices_of(body)) {
    all[v] = velocity;
  }
  solver.write_velocities(all);
}

// The free block, and below it a body of large cells that stands fast.
Scene make_block_on_body(double length) {
  constexpr double kCell = 20e-3;
  const auto cells = static_cast<Index>(std::ceil(length / kCell));
  Scene scene = make_free_block(Affine3d(Translation3d(0, 0, kContactThickness)));
  const BodyId table = scene.add_body(
      "table",
      placed_box({cells + 2, 4, 1}, kCell, Affine3d(Translation3d(-kCell, -kCell, -kCell))),
      tissue());
  scene.fix_where(table, [](const Vector3d& /*x*/) { return true; });
  return scene;
}

}  // namespace

// Would catch sweeps that end early and hold to a body what should slide on it, edges of a mesh
// that stop what slides over them, and friction that does not slide or slides freely.
TEST_CASE("meeting pieces: a block slides down a tilted body as it must", "[validation]") {
  const TimeIntegration integration = any_integration();
  const float friction = GENERATE(0.1F, 0.3F, 0.6F);
  CAPTURE(static_cast<int>(integration), friction);
  const float slope = 1.3F * std::atan(friction);
  const double acceleration = kGravity * (std::sin(slope) - friction * std::cos(slope));
  Scene scene = make_block_on_body(acceleration / 2);
  scene.set_gravity(gravity_on(slope).cwiseProduct(Vector3f::UnitZ()));
  Solver solver(scene, vertex_blocks(integration));
  solver.set_body_contact(0, 1, {kContactThickness, friction});
  run(solver, kUsualStep, 0.5F);
  const double before = mean_of_body(solver, 0).x();
  solver.set_gravity(gravity_on(slope));

  Vector3d force = Vector3d::Zero();
  double lowest = 1;
  for (int i = 0; i < 200; ++i) {
    solver.step(kUsualStep);
    force += force_between(solver, 0, 1) / 200;
    for (const Index v : solver.tissue().vertices_of(0)) {
      lowest = std::min(lowest, static_cast<double>(solver.positions()[v].z()));
    }
  }

  CHECK(mean_of_body(solver, 0).x() - before == Approx(acceleration / 2).epsilon(0.02));
  const double weight = kBlockMass * kGravity * std::cos(slope);
  CHECK(force.z() == Approx(weight).epsilon(0.01));
  CHECK(force.x() == Approx(-friction * weight).epsilon(0.01));
  CHECK(lowest > kContactThickness - 1e-2 * kBlockEdge);
}

// Would catch friction that creeps, or a rigid motion that breaks it loose.
TEST_CASE("meeting pieces: below the angle of friction a block stays on a body", "[validation]") {
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(integration));
  constexpr float kFriction = 0.3F;
  Scene scene = make_block_on_body(20e-3);
  scene.set_gravity(gravity_on(0.95F * std::atan(kFriction)));
  Solver solver(scene, vertex_blocks(integration));
  solver.set_body_contact(0, 1, {kContactThickness, kFriction});
  run(solver, kUsualStep, 1);
  const Vector3d before = mean_of_body(solver, 0);

  run(solver, kUsualStep, 1);

  CHECK((mean_of_body(solver, 0) - before).norm() < 0.01 * kBlockEdge);
  const Vector3d weight = kBlockMass * scene.gravity().cast<double>();
  CHECK((force_between(solver, 0, 1) + weight).norm() < 1e-3 * weight.norm());
}

// Would catch friction that goes on when a body stands, or ends before.
TEST_CASE("meeting pieces: a block that is pushed along a body stops after v^2 / (2 mu g)",
          "[validation]") {
  const TimeIntegration integration = any_integration();
  constexpr float kFriction = 0.3F, kSpeed = 1;
  CAPTURE(static_cast<int>(integration));
  constexpr double kDistance = kSpeed * kSpeed / (2 * kFriction * kGravity);
  Solver solver(make_block_on_body(kDistance), vertex_blocks(integration));
  solver.set_body_contact(0, 1, {kContactThickness, kFriction});
  run(solver, kUsualStep, 0.5F);
  const double before = mean_of_body(solver, 0).x();
  give_velocity(solver, 0, {kSpeed, 0, 0});

  run(solver, kUsualStep, 1);

  CHECK(mean_of_body(solver, 0).x() - before == Approx(kDistance).epsilon(0.02));
  for (const Vector3f& velocity : solver.velocities()) {
    REQUIRE(velocity.norm() < 1e-4F);
  }
}

// Would catch friction that acts on one of two alone, or more on one than on the other: a block is
// pushed along a plate that lies on a smooth table, until both go as fast.
TEST_CASE("meeting pieces: two bodies that slide on each other end as momentum has it",
          "[validation]") {
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(integration));
  constexpr float kFriction = 0.3F, kSpeed = 0.35F, kShort = 1e-3F;
  constexpr double kPlateMass = 8e-3;  // kg
  const double plate_height = 2 * kBlockEdge;
  Scene scene = make_free_block(Affine3d(Translation3d(0, 0, plate_height + kContactThickness)));
  scene.add_body("plate", placed_box({8, 4, 2}, kBlockEdge, Affine3d::Identity()), tissue());
  Solver solver(scene, vertex_blocks(integration));
  solver.add_half_space({}, 0);
  solver.set_body_contact(0, 1, {kContactThickness, kFriction});
  run(solver, kShort, 0.5F);
  give_velocity(solver, 0, {kSpeed, 0, 0});
  const double start = mean_of_body(solver, 0).x() - mean_of_body(solver, 1).x();
  const double momentum = kBlockMass * kSpeed;
  double most = 0;

  for (int i = 0; i < 300; ++i) {
    solver.step(kShort);
    const Vector3d now = momentum_of_body(solver, 0) + momentum_of_body(solver, 1);
    most = std::max({most, std::abs(now.x() - momentum), std::abs(now.y())});
  }

  CHECK(most < 1e-5 * momentum);
  const double common = momentum / (kBlockMass + kPlateMass);
  CHECK(momentum_of_body(solver, 0).x() / kBlockMass == Approx(common).epsilon(1e-3));
  CHECK(momentum_of_body(solver, 1).x() / kPlateMass == Approx(common).epsilon(1e-3));
  // v^2 / 2 of the relative motion over its deceleration
  const double deceleration = kFriction * kGravity * (1 + kBlockMass / kPlateMass);
  CHECK(mean_of_body(solver, 0).x() - mean_of_body(solver, 1).x() - start ==
        Approx(kSpeed * kSpeed / (2 * deceleration)).epsilon(0.02));
}

// Would catch momentum that an impact makes, or a rigid motion that moves one of two alone.
TEST_CASE("meeting pieces: two bodies that collide at an angle keep their momentum",
          "[validation]") {
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(integration));
  Scene scene = make_free_block();
  scene.add_body("other", placed_box({3, 3, 3}, 4e-3, Affine3d(Translation3d(21e-3, 5e-3, -3e-3))),
                 tissue(60e3F));
  scene.set_gravity(Vector3f::Zero());
  Solver solver(scene, vertex_blocks(integration));
  solver.set_body_contact(0, 1, {kContactThickness, 0.4F});
  give_velocity(solver, 0, {0.2F, 0.1F, 0.02F});
  const Vector3d before = momentum_of_body(solver, 0) + momentum_of_body(solver, 1);
  bool has_met = false;

  for (int i = 0; i < 60; ++i) {
    solver.step(kUsualStep);
    has_met = has_met || force_between(solver, 1, 0).norm() > 0;
    const Vector3d now = momentum_of_body(solver, 0) + momentum_of_body(solver, 1);
    REQUIRE((now - before).norm() < 1e-5 * before.norm());
  }
  CHECK(has_met);
  CHECK(momentum_of_body(solver, 1).x() > 0.2 * before.x());
  CHECK(momentum_of_body(solver, 1).y() > 0);
}

// Would catch a stack that creeps, leans on one contact, or does not bear its weight: on a table
// that is a tool, tilted to a share of the angle of friction between the blocks.
TEST_CASE("meeting pieces: of a stack on a table the upper block stays, or slides as it must",
          "[validation]") {
  const TimeIntegration integration = any_integration();
  const float share = GENERATE(0.95F, 1.3F);
  CAPTURE(static_cast<int>(integration), share);
  constexpr float kFriction = 0.3F;
  const float slope = share * std::atan(kFriction);
  const double plate_height = 2 * kBlockEdge;
  Scene scene = make_free_block(Affine3d(Translation3d(0, 0, plate_height + kContactThickness)));
  scene.add_body("plate", placed_box({10, 4, 2}, kBlockEdge, Affine3d::Identity()), tissue());
  scene.set_gravity(gravity_on(slope).cwiseProduct(Vector3f::UnitZ()));
  Solver solver(scene, vertex_blocks(integration));
  const ToolId table = solver.add_half_space({}, 2 * kFriction);
  solver.set_body_contact(0, 1, {kContactThickness, kFriction});
  run(solver, kUsualStep, 0.5F);
  solver.set_gravity(gravity_on(slope));
  if (share < 1) {
    run(solver, kUsualStep, 0.5F);
  }
  const Vector3d upper = mean_of_body(solver, 0), lower = mean_of_body(solver, 1);
  const int steps = share < 1 ? 200 : 40;

  run(solver, kUsualStep, static_cast<float>(steps) * kUsualStep);

  const double time = steps * kUsualStep;
  const double gone = mean_of_body(solver, 0).x() - upper.x();
  CHECK((mean_of_body(solver, 1) - lower).norm() < 0.01 * kBlockEdge);
  if (share < 1) {
    CHECK(std::abs(gone) < 0.01 * kBlockEdge);
  } else {
    const double distance =
        kGravity / 2 * (std::sin(slope) - kFriction * std::cos(slope)) * time * time;
    CHECK(gone == Approx(distance).epsilon(0.02));
  }
  const double weight = kGravity * std::cos(slope);
  CHECK(force_between(solver, 0, 1).z() == Approx(kBlockMass * weight).epsilon(0.01));
  CHECK(solver.tool_force(table).z() == Approx(-(kBlockMass + 10e-3) * weight).epsilon(0.01));
}

// Would catch a motion that depends on who computes it, or that a snapshot leaves out.
TEST_CASE("meeting pieces: any number of threads has the serial bits, and a snapshot goes on",
          "[determinism]") {
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(integration));
  const auto hash = [&](Executor executor, bool restores) {
    SolverOptions options = vertex_blocks(integration);
    options.executor = std::move(executor);
    options.math = MathMode::strict;
    Affine3d pose(Eigen::AngleAxisd(0.3, Vector3d::UnitY()));
    pose.pretranslate(Vector3d(0, 0, 20e-3));
    Scene scene = make_free_block(pose);
    scene.add_body("plate", placed_box({6, 4, 2}, kBlockEdge, Affine3d::Identity()), tissue());
    scene.set_gravity(gravity_on(0.6F));
    Solver solver(scene, options);
    solver.add_half_space({}, 0.3F);
    solver.set_body_contact(0, 1, {kContactThickness, 0.3F});
    for (int i = 0; i < 40; ++i) {
      solver.step(kUsualStep);
      if (restores && i == 25) {
        const Snapshot snapshot = solver.snapshot();
        CHECK(!snapshot.body_contacts.empty());
        solver.step(kUsualStep);
        solver.restore(snapshot);
      }
    }
    return solver.state_hash();
  };
  const std::uint64_t serial = hash(executor::serial(), false);
  CHECK(hash(executor::threads(1), false) == serial);
  CHECK(hash(executor::threads(3), false) == serial);
  CHECK(hash(executor::threads(2), true) == serial);
}

}  // namespace pbdsurg
