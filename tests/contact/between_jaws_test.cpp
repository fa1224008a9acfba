// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/between_jaws.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_refused;

constexpr float kSide = 20e-3F;

// A cube of six tetrahedra on the origin, 20 mm.
Scene make_cube() {
  Scene scene;
  scene.add_body("cube", testing::make_box({1, 1, 1}, kSide), {});
  return scene;
}

ToolPose at(const Eigen::Vector3f& place) {
  return ToolPose(Eigen::Translation3f(place));
}

Eigen::Vector3f place_of(const TissuePoint& point, const Scene& scene) {
  Eigen::Vector3f x = Eigen::Vector3f::Zero();
  for (int k = 0; k < 3; ++k) {
    x += point.weights[k] * scene.positions()[point.vertices[k]].cast<float>();
  }
  return x;
}

const JawPad kPad{.half_length = 4e-3F, .half_width = 2e-3F};

}  // namespace

// Would catch points beside the grid of the pad, of the wrong face, or with wrong weights: no
// vertex of the mesh is near the pad.
TEST_CASE("between jaws: a grid of points on both faces of a coarse mesh", "[unit]") {
  const Scene scene = make_cube();
  Solver solver(scene);
  const ToolId tool = solver.add_tool({}, at({8e-3F, 9e-3F, 10e-3F}));
  const std::vector<TissuePoint> points = find_points_between(solver, 0, tool, kPad, 24e-3F, 2e-3F);
  REQUIRE(points.size() == 2 * 4 * 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t in_face = i % 8;
    const Eigen::Vector3f expected(5e-3F + 2e-3F * static_cast<float>(in_face / 2),
                                   8e-3F + 2e-3F * static_cast<float>(in_face % 2),
                                   i < 8 ? kSide : 0.0F);
    CHECK((place_of(points[i], scene) - expected).norm() < 1e-7F);
  }
  solver.grasp(tool, points, {.pad = kPad});
  CHECK(solver.tool_grip(tool).points.size() == points.size());
}

// Would catch jaws that reach beyond their opening, and a tool's frame that is not turned along.
TEST_CASE("between jaws: only what lies between them, in the tool's frame", "[unit]") {
  const Scene scene = make_cube();
  Solver solver(scene);
  const ToolId low = solver.add_tool({}, at({8e-3F, 9e-3F, 18e-3F}));
  CHECK(find_points_between(solver, 0, low, kPad, 5e-3F, 2e-3F).size() == 16);  // the top twice
  CHECK(find_points_between(solver, 0, low, kPad, 3e-3F, 2e-3F).empty());
  const ToolPose turned =
      at({8e-3F, 10e-3F, 9e-3F}) *
      Eigen::AngleAxisf(std::numbers::pi_v<float> / 2, Eigen::Vector3f::UnitX());
  const ToolId tool = solver.add_tool({}, turned);
  for (const TissuePoint& point : find_points_between(solver, 0, tool, kPad, 24e-3F, 2e-3F)) {
    const float y = place_of(point, scene).y();
    CHECK((std::abs(y) < 1e-7F || std::abs(y - kSide) < 1e-7F));
  }
  const ToolId edge = solver.add_tool({}, at({24e-3F, 9e-3F, 10e-3F}));
  CHECK(find_points_between(solver, 0, edge, kPad, 24e-3F, 2e-3F).empty());
}

TEST_CASE("between jaws: what is out of range is refused", "[errors]") {
  Solver solver(make_cube());
  const ToolId tool = solver.add_tool({}, at({0, 0, 0}));
  const auto find = [&](Index body, const JawPad& pad, float opening, float spacing) {
    return [&solver, tool, body, pad, opening, spacing] {
      static_cast<void>(find_points_between(solver, body, tool, pad, opening, spacing));
    };
  };
  check_refused(find(3, kPad, 0.01F, 1e-3F), "3");
  check_refused(find(0, {.half_width = -1}, 0.01F, 1e-3F), "half width is -1");
  check_refused(find(0, kPad, 0, 1e-3F), "opening is 0");
  check_refused(find(0, kPad, 0.01F, std::nanf("")), "spacing of points is nan");
  check_refused([&] { static_cast<void>(find_points_between(solver, 0, ToolId(7), kPad, 1, 1)); },
                "no tool 7");
}

}  // namespace pbdsurg
