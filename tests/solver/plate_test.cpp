// SPDX-License-Identifier: Apache-2.0
// Plates: capsules that sweep along a way.
#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/feature_meeting.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::Approx;
using testing::ContainsSubstring;

constexpr float kPlateStep = 5e-3F;
constexpr float kPlateRadius = 1e-3F;
constexpr float kPlateEdge = 3e-3F;

ToolPose plate_at(const Vector3f& place, float angle = 0) {
  return testing::at(place) * Eigen::AngleAxisf(angle, Vector3f::UnitX());
}

// Around its middle.
Capsule plate(float length, float width) {
  return {{-length / 2, -width / 2, 0}, {length / 2, -width / 2, 0}, kPlateRadius, {0, width, 0}};
}

// 18 by 18 by 9 mm.
Scene plate_block() {
  return testing::make_soft_block({6, 6, 3}, kPlateEdge);
}

constexpr Vector3f::Scalar kTop = 3 * kPlateEdge, kMiddle = 3 * kPlateEdge;

// The force of a tool that comes down by a depth within a second, N.
float felt(Solver& solver, ToolId tool, const Vector3f& from, float depth, float angle = 0) {
  constexpr int kSteps = 200;
  for (int i = 1; i <= kSteps; ++i) {
    const float share = std::min(1.0F, static_cast<float>(i) / (kSteps / 2));
    solver.move_tool(tool, plate_at(from - Vector3f(0, 0, share * depth), angle));
    solver.step(kPlateStep);
  }
  return solver.tool_force(tool).z();
}

SolverOptions plate_options() {
  return {.method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block)};
}

}  // namespace

// Would catch a side, a corner or a way through the rectangle that no feature finds.
TEST_CASE("plate: of a triangle, one feature is as near as the triangle is", "[unit]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto any = [&] {
    const float x = uniform(random), y = uniform(random);
    return Vec3<float>{x, y, uniform(random)};
  };
  const bool is_plate = GENERATE(true, false);
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i, is_plate);
    const Vec3<float> start = any(), along = any(), other = any();
    const Vec3<float> across = other - (dot(other, along) / dot(along, along)) * along;
    const PlacedCapsule plate{start, 0.1F, start + along, (is_plate ? 1.0F : 0.0F) * across};
    const Vec3<float> x[3] = {any(), any(), any()};
    float nearest = feature_meeting::meet(3, x, plate).distance;
    for (int k = 0; k < 3; ++k) {
      const Vec3<float> edge[3] = {x[k], x[(k + 1) % 3]};
      nearest = std::min({nearest, feature_meeting::meet(1, edge, plate).distance,
                          feature_meeting::meet(2, edge, plate).distance});
    }
    float expected = kInfinity;
    constexpr int kCells = 60;
    for (int b = 0; b <= kCells; ++b) {
      for (int c = 0; b + c <= kCells; ++c) {
        const float of_b = static_cast<float>(b) / kCells, of_c = static_cast<float>(c) / kCells;
        const Vec3<float> point = (1 - of_b - of_c) * x[0] + of_b * x[1] + of_c * x[2];
        expected =
            std::min(expected, feature_meeting::length(point - plate.at(plate.closest(point))));
      }
    }
    CHECK(nearest == Approx(expected).margin(0.03));
  }
}

// Would catch a rectangle that vertices find in another place than its plane, or edges and
// triangles that meet its inside.
TEST_CASE("plate: one that is wider than a block feels what a half space feels", "[validation]") {
  const SolverOptions options = plate_options();
  CAPTURE(static_cast<int>(options.method));
  const Vector3f above(kMiddle, kMiddle, kTop + kPlateRadius);
  constexpr float kDepth = 1e-3F;
  Solver with_plate(plate_block(), options), with_table(plate_block(), options);
  const std::array wide{plate(40e-3F, 40e-3F)};
  const ToolId tool = with_plate.add_tool(wide, plate_at(above), {ContactFeatures::all, 0});
  const ToolId table =
      with_table.add_half_space({{0, 0, -kPlateRadius}, {0, 0, -1}}, 0, plate_at(above));
  const float expected = felt(with_table, table, above, kDepth);
  CHECK(felt(with_plate, tool, above, kDepth) == Approx(expected).epsilon(5e-3));
  CHECK(expected > 0.1F);
}

// Would catch sides that edges and triangles do not find.
TEST_CASE("plate: one on its side feels what a capsule there feels", "[validation]") {
  const SolverOptions options = plate_options();
  CAPTURE(static_cast<int>(options.method));
  // between rows of vertices
  const Vector3f above(kMiddle, kMiddle + 0.4F * kPlateEdge, kTop + kPlateRadius);
  constexpr float kDepth = 2e-3F, kLength = 7e-3F;
  Solver with_plate(plate_block(), options), with_capsule(plate_block(), options);
  const std::array upright{
      Capsule{{-kLength / 2, 0, 0}, {kLength / 2, 0, 0}, kPlateRadius, {0, 0, 10e-3F}}};
  std::array rod{upright};
  rod[0].across.setZero();
  const ToolId tool = with_plate.add_tool(upright, plate_at(above), {ContactFeatures::all, 0});
  const ToolId other = with_capsule.add_tool(rod, plate_at(above), {ContactFeatures::all, 0});
  const float expected = felt(with_capsule, other, above, kDepth);
  CHECK(felt(with_plate, tool, above, kDepth) == Approx(expected).epsilon(2e-2));
  CHECK(expected > 0.05F);
}

// Would catch corners and sides that pass between vertices: a plate smaller than a triangle.
TEST_CASE("plate: a small one feels tissue wherever it meets it", "[validation]") {
  const SolverOptions options = plate_options();
  const auto offset =
      GENERATE(Eigen::Vector2f(0, 0), Eigen::Vector2f(0.5F, 0), Eigen::Vector2f(0.6F, 0.3F));
  const float angle = GENERATE(0.0F, 1.2F);
  CAPTURE(static_cast<int>(options.method), offset.x(), offset.y(), angle);
  const float lowest = kPlateRadius + 0.5e-3F * std::sin(angle);
  const Vector3f above(kMiddle + offset.x() * kPlateEdge, kMiddle + offset.y() * kPlateEdge,
                       kTop + lowest);
  Solver solver(plate_block(), options);
  const std::array small{plate(1e-3F, 1e-3F)};
  const ToolId tool = solver.add_tool(small, plate_at(above, angle), {ContactFeatures::all, 0});
  // as a ball of that radius: 2 a E / (1 - nu^2) a meter
  constexpr float kDepth = 2e-3F, kPunch = 2 * kPlateRadius * 10e3F / (1 - 0.45F * 0.45F) * kDepth;
  const float force = felt(solver, tool, above, kDepth, angle);
  CHECK(force > 0.7F * kPunch);
  CHECK(force < 6 * kPunch);
}

// Would catch a rectangle that lets fast tissue through, or sides on which it forgets it.
TEST_CASE("plate: a block that falls on it stays above", "[validation]") {
  const SolverOptions options = plate_options();
  CAPTURE(static_cast<int>(options.method));
  Solver solver(testing::make_free_block(), options);
  const std::vector<Vector3f> start = solver.positions();
  float lowest = start[0].z();
  Vector3f middle = Vector3f::Zero();
  for (const Vector3f& x : start) {
    lowest = std::min(lowest, x.z());
    middle += x / static_cast<float>(start.size());
  }
  const float below = lowest - 20e-3F;  // so that it comes at 0.6 m/s
  const std::array tray{plate(60e-3F, 60e-3F)};
  solver.add_tool(tray, plate_at({middle.x(), middle.y(), below}), {ContactFeatures::all, 0.3F});
  float deepest = 0;
  for (int i = 0; i < 200; ++i) {
    solver.step(kPlateStep);
    for (const Vector3f& x : solver.positions()) {
      deepest = std::max(deepest, below + kPlateRadius - x.z());
    }
  }
  CHECK(deepest < 0.5e-3F);
}

// Would catch one that a joint or a pose turns without its width.
TEST_CASE("plate: joints and poses turn it", "[unit]") {
  Solver solver(plate_block(), {});
  const std::array upright{
      Capsule{{-5e-3F, 0, 0}, {5e-3F, 0, 0}, kPlateRadius, {0, 0, -10e-3F}}};  // hangs down
  const Vector3f above(kMiddle, kMiddle, kTop + 5e-3F);
  const ToolId tool =
      solver.add_tool(upright, plate_at(above, EIGEN_PI / 2), {ContactFeatures::all, 0},
                      std::array{ToolJoint{{0, 0, 0}, {1, 0, 0}, 0, 1}});
  solver.step(kPlateStep);
  CHECK(solver.tool_contacts(tool).empty());  // it lies flat, 4 mm above
  for (int i = 1; i <= 40; ++i) {
    solver.set_joint(tool, 0, -static_cast<float>(i) / 40 * static_cast<float>(EIGEN_PI) / 2);
    solver.step(kPlateStep);
  }
  CHECK_FALSE(solver.tool_contacts(tool).empty());  // it stands, and its side is 5 mm deep
  CHECK(solver.tool_force(tool).z() > 0.05F);
}

TEST_CASE("plate: one that is none is refused", "[unit]") {
  Solver solver(plate_block(), {});
  const auto refuses = [&](const Capsule& capsule) {
    CHECK_THROWS_WITH(solver.add_tool({&capsule, 1}, plate_at({0, 0, 0})),
                      ContainsSubstring("plate 0 is"));
    CHECK_THROWS_AS(solver.add_tool({&capsule, 1}, plate_at({0, 0, 0})), InvalidArgument);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  refuses({{0, 0, 0}, {0, 0, 0}, 1e-3F, {0, 1e-3F, 0}});
  refuses({{0, 0, 0}, {1e-3F, 0, 0}, 1e-3F, {1e-4F, 1e-3F, 0}});
  refuses({{0, 0, 0}, {1e-3F, 0, 0}, 1e-3F, {0, kNan, 0}});
}

}  // namespace pbdsurg
