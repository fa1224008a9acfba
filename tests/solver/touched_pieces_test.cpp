// SPDX-License-Identifier: Apache-2.0
// Free bodies on the surfaces of tools: how they rest, stick, slide and fall.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "bench/support/static_energy.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::Approx;

using testing::gravity_on;
using testing::kBlockCells;
using testing::kBlockEdge;
using testing::kBlockMass;
using testing::kGravity;
using testing::make_free_block;
using testing::mean_of;
using testing::placed_box;
using testing::run;
using testing::tissue;
using testing::vertex_blocks;

float lowest(const Solver& solver) {
  float low = 1;
  for (const Vector3f& x : solver.positions()) {
    low = std::min(low, x.z());
  }
  return low;
}

}  // namespace

// Would catch sweeps that end early and hold to the slope what slides, friction that does not slide
// or slides freely, and forces that are not those that decide the motion.
TEST_CASE("touched pieces: a block slides down a slope as it must", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  const float step = GENERATE(5e-3F, 16e-3F);
  const float friction = GENERATE(0.1F, 0.3F, 0.6F);
  CAPTURE(static_cast<int>(integration), step, friction);
  const float slope = 1.3F * std::atan(friction);
  Scene scene = make_free_block();
  scene.set_gravity(gravity_on(slope).cwiseProduct(Vector3f::UnitZ()));
  Solver solver(scene, vertex_blocks(integration));
  const ToolId table = solver.add_half_space({}, friction);
  run(solver, step, 0.5F);
  const double before = mean_of(solver).x();
  solver.set_gravity(gravity_on(slope));

  const auto count = std::lround(1 / step);
  Vector3d force = Vector3d::Zero();
  float deepest = 0;
  for (int i = 0; i < count; ++i) {
    solver.step(step);
    force += solver.tool_force(table).cast<double>() / count;
    deepest = std::min(deepest, lowest(solver));
  }

  const double time = static_cast<double>(count) * step;
  const double distance =
      kGravity / 2 * (std::sin(slope) - friction * std::cos(slope)) * time * time;
  CHECK(mean_of(solver).x() - before == Approx(distance).epsilon(0.02));
  const double weight = kBlockMass * kGravity * std::cos(slope);
  CHECK(force.z() == Approx(-weight).epsilon(0.01));
  CHECK(force.x() == Approx(friction * weight).epsilon(0.01));
  CHECK(deepest > -1e-2 * kBlockEdge);
}

// Would catch friction that creeps, or a rigid motion that breaks it loose.
TEST_CASE("touched pieces: below the angle of friction a block stays", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  const float step = GENERATE(5e-3F, 16e-3F);
  CAPTURE(static_cast<int>(integration), step);
  constexpr float kFriction = 0.3F;
  Scene scene = make_free_block();
  scene.set_gravity(gravity_on(0.95F * std::atan(kFriction)));
  Solver solver(scene, vertex_blocks(integration));
  const ToolId slope = solver.add_half_space({}, kFriction);
  run(solver, step, 1);
  const Vector3d before = mean_of(solver);

  run(solver, step, 1);

  CHECK((mean_of(solver) - before).norm() < 1e-6);
  const Vector3d weight = kBlockMass * scene.gravity().cast<double>();
  CHECK((solver.tool_force(slope).cast<double>() - weight).norm() < 1e-3 * weight.norm());
}

// Would catch friction that goes on when a body stands, or ends before.
TEST_CASE("touched pieces: a block that is pushed stops after v^2 / (2 mu g)", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  constexpr float kFriction = 0.3F, kSpeed = 1, kStep = 5e-3F;
  CAPTURE(static_cast<int>(integration));
  Solver solver(make_free_block(), vertex_blocks(integration));
  solver.add_half_space({}, kFriction);
  run(solver, kStep, 0.5F);
  const double before = mean_of(solver).x();
  solver.write_velocities(std::vector(solver.vertex_count(), Vector3f(kSpeed, 0, 0)));

  run(solver, kStep, 1);

  const double distance = kSpeed * kSpeed / (2 * kFriction * kGravity);
  CHECK(mean_of(solver).x() - before == Approx(distance).epsilon(0.02));
  for (const Vector3f& velocity : solver.velocities()) {
    REQUIRE(velocity.norm() < 1e-4F);
  }
}

// Would catch what bounces off a table, sinks into it, gains energy there, or weighs something
// else.
TEST_CASE("touched pieces: a block that falls comes to rest", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  const float step = GENERATE(5e-3F, 16e-3F);
  const double tilt = GENERATE(0.0, 0.3);
  CAPTURE(static_cast<int>(integration), step, tilt);
  constexpr double kFall = 5e-3;
  Eigen::Affine3d pose(Eigen::AngleAxisd(tilt, Vector3d::UnitY()));
  pose.pretranslate(Vector3d(0, 0, kFall + kBlockCells[0] * kBlockEdge * std::sin(tilt)));
  const Scene scene = make_free_block(pose);
  Solver solver(scene, vertex_blocks(integration));
  const ToolId table = solver.add_half_space({}, 0.3F);
  const bench::StaticEnergy potential(scene);
  const std::span<const double> masses = solver.tissue().masses();
  const auto energy = [&] {
    bench::Positions positions;
    for (const Vector3f& x : solver.positions()) {
      positions.push_back(x.cast<double>());
    }
    double sum = potential.value(positions);
    const std::vector<Vector3f> velocities = solver.velocities();
    for (std::size_t v = 0; v < velocities.size(); ++v) {
      sum += masses[v] / 2 * velocities[v].squaredNorm();
    }
    return sum;
  };
  const double released = kBlockMass * kGravity * kFall;
  const double start = energy();
  double before = start, most = start, most_gain = 0;
  float deepest = 0, highest = 0;
  double impulse = 0;
  bool has_landed = false;
  const auto count = std::lround(2 / step);

  for (int i = 0; i < count; ++i) {
    solver.step(step);
    impulse -= step * solver.tool_force(table).z();
    deepest = std::min(deepest, lowest(solver));
    has_landed = has_landed || solver.tool_force(table).z() < 0;
    highest = has_landed ? std::max(highest, lowest(solver)) : 0;
    const double now = energy();
    most_gain = std::max(most_gain, now - before);
    most = std::max(most, now);
    before = now;
  }

  CHECK(deepest > -1e-2 * kBlockEdge);
  CHECK(highest < 0.01 * kFall);
  if (integration == TimeIntegration::implicit_euler) {
    CHECK(most_gain < 1e-4 * released);
  }
  CHECK(most < start + 1e-4 * released);
  CHECK(solver.tool_force(table).z() == Approx(-kBlockMass * kGravity).epsilon(1e-3));
  CHECK(impulse == Approx(kBlockMass * kGravity * count * step).epsilon(1e-3));
  for (const Vector3f& velocity : solver.velocities()) {
    REQUIRE(velocity.norm() < 1e-4F);
  }
}

// Would catch an impulse that a tool does not feel.
TEST_CASE("touched pieces: a table feels what it takes from the momentum of a block",
          "[validation]") {
  constexpr float kStep = 5e-3F;
  Eigen::Affine3d pose(Eigen::AngleAxisd(0.3, Vector3d(1, 1, 0).normalized()));
  pose.pretranslate(Vector3d(0, 0, 10e-3));
  Solver solver(make_free_block(pose), vertex_blocks(TimeIntegration::implicit_euler));
  const ToolId table = solver.add_half_space({}, 0.5F);
  const std::span<const double> masses = solver.tissue().masses();
  const auto momentum = [&] {
    const std::vector<Vector3f> velocities = solver.velocities();
    Vector3d sum = Vector3d::Zero();
    for (std::size_t v = 0; v < velocities.size(); ++v) {
      sum += masses[v] * velocities[v].cast<double>();
    }
    return sum;
  };
  solver.write_velocities(std::vector(solver.vertex_count(), Vector3f(0.3F, 0.1F, 0)));
  Vector3d before = momentum();
  double most = 0;

  for (int i = 0; i < 100; ++i) {
    solver.step(kStep);
    const Vector3d now = momentum();
    const Vector3d weight = kBlockMass * kGravity * -Vector3d::UnitZ();
    const Vector3d push = weight - solver.tool_force(table).cast<double>();
    most = std::max(most, (now - before - kStep * push).norm());
    before = now;
  }

  CHECK(most < 1e-3 * kBlockMass * kGravity * kStep);
}

// Would catch bodies that share a motion, or contacts that are counted for another body.
TEST_CASE("touched pieces: bodies of different size and stiffness slide each for itself",
          "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  CAPTURE(static_cast<int>(integration));
  constexpr float kFriction = 0.3F, kStep = 5e-3F;
  const float slope = 1.3F * std::atan(kFriction);
  Scene scene = make_free_block();
  const Index first_count = scene.vertex_count();
  scene.add_body("other",
                 placed_box({3, 2, 2}, 4e-3, Eigen::Affine3d(Eigen::Translation3d(0, 50e-3, 0))),
                 tissue(60e3F));
  // a third one flies past, near enough for contacts that do not push
  const Index grounded_count = scene.vertex_count();
  scene.add_body("flying",
                 placed_box({1, 1, 1}, 4e-3, Eigen::Affine3d(Eigen::Translation3d(0, 90e-3, 0.2))),
                 tissue());
  scene.set_gravity({0, 0, -kGravity * std::cos(slope)});
  Solver solver(scene, vertex_blocks(integration));
  solver.add_half_space({}, kFriction);
  run(solver, kStep, 0.15F);
  solver.set_gravity(gravity_on(slope));
  const double first = mean_of(solver, 0, first_count).x();
  const double second = mean_of(solver, first_count, grounded_count - first_count).x();

  run(solver, kStep, 1);

  const double distance = kGravity / 2 * (std::sin(slope) - kFriction * std::cos(slope));
  CHECK(mean_of(solver, 0, first_count).x() - first == Approx(distance).epsilon(0.02));
  CHECK(mean_of(solver, first_count, grounded_count - first_count).x() - second ==
        Approx(distance).epsilon(0.02));
}

// Would catch a tool whose contacts are left out of the balance: in a groove of 90 degrees two
// planes bear 1 / sqrt(2) of the weight each, so friction is sqrt(2) times that of a plane.
TEST_CASE("touched pieces: a bar slides in a groove of two tools, or sticks there",
          "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  const float share = GENERATE(0.95F, 1.3F);
  CAPTURE(static_cast<int>(integration), share);
  constexpr float kFriction = 0.2F, kStep = 5e-3F;
  const float effective = std::sqrt(2.0F) * kFriction, half = std::sqrt(0.5F);
  const float slope = share * std::atan(effective);
  Scene scene;
  scene.add_body("bar",
                 placed_box({4, 3, 3}, kBlockEdge,
                            Eigen::Affine3d(Eigen::AngleAxisd(std::atan(1.0), Vector3d::UnitX()))),
                 tissue());
  scene.set_gravity({0, 0, -kGravity * std::cos(slope)});
  Solver solver(scene, vertex_blocks(integration));
  const ToolId left = solver.add_half_space({{0, 0, 0}, {0, half, half}}, kFriction);
  const ToolId right = solver.add_half_space({{0, 0, 0}, {0, -half, half}}, kFriction);
  run(solver, kStep, 0.5F);
  solver.set_gravity(gravity_on(slope));
  if (share < 1) {
    run(solver, kStep, 0.5F);
  }
  const double before = mean_of(solver).x();

  run(solver, kStep, 1);

  const double gone = mean_of(solver).x() - before;
  if (share < 1) {
    CHECK(std::abs(gone) < 5e-6);
  } else {
    const double distance = kGravity / 2 * (std::sin(slope) - effective * std::cos(slope));
    CHECK(gone == Approx(distance).epsilon(0.02));
  }
  const double weight =
      36 * 1000 * kBlockEdge * kBlockEdge * kBlockEdge * kGravity * std::cos(slope);
  CHECK((solver.tool_force(left) + solver.tool_force(right)).z() == Approx(-weight).epsilon(0.01));
}

// Would catch a motion that depends on who computes it, or that a snapshot leaves out.
TEST_CASE("touched pieces: any number of threads has the serial bits, and a snapshot goes on",
          "[determinism]") {
  const TimeIntegration integration = testing::any_integration();
  CAPTURE(static_cast<int>(integration));
  const auto hash = [&](Executor executor, bool restores) {
    SolverOptions options = vertex_blocks(integration);
    options.executor = std::move(executor);
    options.math = MathMode::strict;
    Eigen::Affine3d pose(Eigen::AngleAxisd(0.3, Vector3d::UnitY()));
    pose.pretranslate(Vector3d(0, 0, 8e-3));
    Scene scene = make_free_block(pose);
    scene.set_gravity(gravity_on(0.6F));
    Solver solver(scene, options);
    solver.add_half_space({}, 0.3F);
    for (int i = 0; i < 40; ++i) {
      solver.step(5e-3F);
      if (restores && i == 25) {
        const Snapshot snapshot = solver.snapshot();
        CHECK(!snapshot.contacts.empty());
        solver.step(5e-3F);
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
