// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/draw_list.h"

#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::ContainsSubstring;

/// Two parallel triangles before the default camera, the farther one first or last.
Surface two_triangles(float first_z, float second_z) {
  Surface surface;
  surface.name = "pair";
  for (const float z : {first_z, second_z}) {
    surface.positions.insert(surface.positions.end(), {{0, 0, z}, {0.01f, 0, z}, {0, 0.01f, z}});
  }
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  return surface;
}

}  // namespace

TEST_CASE("draw list: blended triangles run from far to near, those of kept surfaces among them",
          "[unit]") {
  const float first = GENERATE(0.0f, 0.02f);  // the eye is at z = 0.1
  SceneView view;
  view.sheets = {two_triangles(first, 0.02f - first)};
  view.sheets[0].look.opacity = 0.5f;
  Surface between = two_triangles(0.01f, 0.03f);
  between.triangles.pop_back();
  between.look.opacity = 0.5f;

  // vertices of kept surfaces come first
  const DrawList list = make_draw_list(view, std::array<const Surface*, 1>{&between});

  const std::uint32_t near_vertex = first == 0.02f ? 6 : 9;
  CHECK(list.tissue.empty());
  CHECK(list.blended[0] == 15 - near_vertex);
  CHECK(list.blended[3] == 0);
  CHECK(list.blended[6] == near_vertex);
}

// Would catch one look for both, and a slot that is empty or lost.
TEST_CASE("draw list: inner triangles have the inner look", "[unit]") {
  SceneView view;
  view.sheets = {two_triangles(0, 0.01f)};
  Surface& sheet = view.sheets[0];
  sheet.triangles.push_back({4, 4, 5});
  sheet.is_inner = {0, 1, 1};
  sheet.inner_look.gloss = 0.25f;

  const DrawList list = make_draw_list(view);

  REQUIRE(list.tissue.size() == 6);
  CHECK(list.materials.at(list.vertices[list.tissue[0]].material).surface.x() == sheet.look.gloss);
  CHECK(list.materials.at(list.vertices[list.tissue[3]].material).surface.x() == 0.25f);
}

TEST_CASE("draw list: a triangle with a corner that is not finite is left out", "[unit]") {
  SceneView view;
  view.sheets = {two_triangles(0, 0.01f)};
  view.sheets[0].positions[1].y() =
      GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity());

  const DrawList list = make_draw_list(view);

  CHECK(list.tissue == std::vector<std::uint32_t>{3, 4, 5});
  CHECK(std::isfinite(list.farthest));
}

TEST_CASE("draw list: a surface that contradicts itself is refused by name", "[unit]") {
  SceneView view;
  view.sheets = {two_triangles(0, 0.01f)};
  Surface& surface = view.sheets[0];

  surface.burn.resize(5);
  CHECK_THROWS_WITH(make_draw_list(view), ContainsSubstring("'pair'") && ContainsSubstring("burn"));
  surface.burn.clear();
  surface.triangles[1][2] = 6;
  CHECK_THROWS_WITH(make_draw_list(view),
                    ContainsSubstring("triangle 1") && ContainsSubstring("vertex 6"));
  surface.triangles[1][2] = 5;
  surface.look.detail_size = 0;
  CHECK_THROWS_AS(make_draw_list(view), pbdsurg::InvalidArgument);
}

TEST_CASE("draw list: normals that are given replace those of the triangles", "[unit]") {
  SceneView view;
  view.sheets = {two_triangles(0, 0.01f)};
  CHECK(make_draw_list(view).vertices[0].normal == Eigen::Vector3f::UnitZ());
  view.sheets[0].normals.assign(6, Eigen::Vector3f::UnitX());
  CHECK(make_draw_list(view).vertices[0].normal == Eigen::Vector3f::UnitX());
}

// Would catch a colour that counts beyond its cover where corners of a triangle differ.
TEST_CASE("draw list: a burn's colour is linear and weighed by its cover", "[unit]") {
  SceneView view;
  view.sheets = {two_triangles(0, 0.01f)};
  view.sheets[0].burn.assign(6, Eigen::Vector4f(1, 0, 1, 0.25f));
  view.sheets[0].burn[1].x() = std::numeric_limits<float>::quiet_NaN();
  const DrawList list = make_draw_list(view);
  CHECK(list.vertices[0].burn == Eigen::Vector4f(0.25f, 0, 0.25f, 0.25f));
  CHECK(list.vertices[1].burn == Eigen::Vector4f::Zero());
}

TEST_CASE("draw list: strands and smoke that show nothing are left out", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector4f color(1, 1, 1, 1);
  SceneView view;
  view.strands = {{{0, 0, 0}, {0, 0, 0}, color, 0.001f},
                  {{0, 0, 0}, {0, 0, 0.05f}, color, 0.001f},  // along the line of sight
                  {{0, nan, 0}, {0, 0.01f, 0}, color, 0.001f},
                  {{0, 0, 0}, {0.01f, 0, 0}, color, 0.001f}};
  view.smoke = {{{nan, 0, 0}, 0.01f, 0.5f}, {{0, 0, 0}, 0.01f, 0.5f}};

  const DrawList list = make_draw_list(view);

  CHECK(list.tissue.size() == 6);
  CHECK(list.smoke.size() == 6);
}

}  // namespace cholecystectomy
