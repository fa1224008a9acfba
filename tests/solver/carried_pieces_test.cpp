// SPDX-License-Identifier: Apache-2.0
// Free bodies that tools with surfaces carry, push and squeeze.
#include <cmath>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/free_block.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kBlockEdge;
using testing::kBlockMass;
using testing::kGravity;
using testing::make_free_block;
using testing::mean_of;
using testing::run;
using testing::vertex_blocks;

}  // namespace

// Would catch friction that knows how tissue goes, and not the tool, and a force that is not what a
// body is carried by.
TEST_CASE("carried pieces: a table that moves takes a block with it", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  CAPTURE(static_cast<int>(integration));
  constexpr float kFriction = 0.3F, kStep = 5e-3F, kSpeed = 0.5F, kRise = 2;
  Solver solver(make_free_block(), vertex_blocks(integration));
  const ToolId table = solver.add_half_space({}, kFriction);
  run(solver, kStep, 0.5F);
  const double before = mean_of(solver).x();
  ToolPose pose = ToolPose::Identity();
  const auto move = [&](float along, float up) {
    pose.translation() += kStep * Eigen::Vector3f(along, 0, up);
    solver.move_tool(table, pose);
    solver.step(kStep);
  };

  for (int i = 0; i < 100; ++i) {
    move(kSpeed, 0);
  }
  const double lag = pose.translation().x() - (mean_of(solver).x() - before);
  double force = 0;
  for (int i = 1; i <= 60; ++i) {
    move(kSpeed, static_cast<float>(i) * kStep * kRise);
    force -= i > 20 ? solver.tool_force(table).z() / 40 : 0;
  }

  CHECK(lag == Approx(kSpeed * kSpeed / (2 * kFriction * kGravity)).epsilon(0.02));
  CHECK(force == Approx(kBlockMass * (kGravity + kRise)).epsilon(0.01));
}

// Would catch contacts of one tool that hold against another.
TEST_CASE("carried pieces: who pushes a block along a table feels its friction", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  CAPTURE(static_cast<int>(integration));
  constexpr float kFriction = 0.3F, kStep = 5e-3F, kSpeed = 0.1F;
  Solver solver(make_free_block(), vertex_blocks(integration));
  const ToolId table = solver.add_half_space({}, kFriction);
  run(solver, kStep, 0.5F);
  const Capsule bar{{0, -0.1F, 0}, {0, 0.1F, 0}, 2e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(-2.5e-3F, 10e-3F, 4e-3F);
  const ToolId pusher = solver.add_tool({&bar, 1}, pose, {ContactFeatures::all, 0});

  double pushed = 0, dragged = 0;
  for (int i = 0; i < 100; ++i) {
    pose.translation().x() += kSpeed * kStep;
    solver.move_tool(pusher, pose);
    solver.step(kStep);
    pushed -= i < 50 ? 0 : solver.tool_force(pusher).x() / 50;
    dragged += i < 50 ? 0 : solver.tool_force(table).x() / 50;
  }

  CHECK(pushed == Approx(kFriction * kBlockMass * kGravity).epsilon(0.01));
  CHECK(dragged == Approx(kFriction * kBlockMass * kGravity).epsilon(0.01));
}

// Would catch jaws whose forces differ, or that hold what slides, and a rigid motion that takes
// pushes that cancel for one.
TEST_CASE("carried pieces: jaws hold a block, or let it slide", "[validation]") {
  const TimeIntegration integration = testing::any_integration();
  const float friction = GENERATE(0.02F, 0.3F);
  CAPTURE(static_cast<int>(integration), friction);
  constexpr float kStep = 5e-3F, kSqueeze = 1e-3F;
  constexpr float kWidth = 4 * static_cast<float>(kBlockEdge);
  Scene scene = make_free_block();
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, vertex_blocks(integration));
  const ToolId left = solver.add_half_space({{0, 0, 0}, {1, 0, 0}}, friction);
  const ToolId right = solver.add_half_space({{kWidth, 0, 0}, {-1, 0, 0}}, friction);
  ToolPose pose = ToolPose::Identity();
  for (int i = 0; i < 100; ++i) {
    pose.translation().x() -= kSqueeze / 100;
    solver.move_tool(right, pose);
    solver.step(kStep);
  }
  run(solver, kStep, 0.5F);
  solver.set_gravity({0, 0, -kGravity});
  if (friction > 0.1F) {
    run(solver, kStep, 0.5F);
  }
  const double before = mean_of(solver).z();

  constexpr int kCount = 60;
  double first = 0, second = 0;
  for (int i = 0; i < kCount; ++i) {
    solver.step(kStep);
    first -= solver.tool_force(left).x() / kCount;
    second += solver.tool_force(right).x() / kCount;
  }

  const double gone = before - mean_of(solver).z();
  CHECK(first == Approx(second).epsilon(1e-3));
  if (friction > 0.1F) {
    CHECK(2 * friction * first > kBlockMass * kGravity);
    CHECK(std::abs(gone) < 1e-6);
  } else {
    const double time = kCount * static_cast<double>(kStep);
    CHECK(gone ==
          Approx((kGravity - 2 * friction * first / kBlockMass) * time * time / 2).epsilon(0.02));
  }
}

}  // namespace pbdsurg
