// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/draw_list.h"

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

TEST_CASE("draw list: blended triangles run from far to near, opaque ones from near to far",
          "[unit]") {
  const float first = GENERATE(0.0f, 0.02f);  // the eye is at z = 0.1
  RenderSnapshot snapshot;
  snapshot.surfaces = {two_triangles(first, 0.02f - first)};
  const std::uint32_t near_vertex = first == 0.02f ? 0 : 3;

  CHECK(make_draw_list(snapshot).tissue[0] == near_vertex);
  snapshot.surfaces[0].look.opacity = 0.5f;
  const DrawList blended = make_draw_list(snapshot);
  CHECK(blended.tissue.empty());
  CHECK(blended.blended[3] == near_vertex);
}

TEST_CASE("draw list: a triangle with a corner that is not finite is left out", "[unit]") {
  RenderSnapshot snapshot;
  snapshot.surfaces = {two_triangles(0, 0.01f)};
  snapshot.surfaces[0].positions[1].y() =
      GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity());

  const DrawList list = make_draw_list(snapshot);

  CHECK(list.tissue == std::vector<std::uint32_t>{3, 4, 5});
  CHECK(std::isfinite(list.farthest));
}

TEST_CASE("draw list: a surface that contradicts itself is refused by name", "[unit]") {
  RenderSnapshot snapshot;
  snapshot.surfaces = {two_triangles(0, 0.01f)};
  Surface& surface = snapshot.surfaces[0];

  surface.burn.resize(5);
  CHECK_THROWS_WITH(make_draw_list(snapshot),
                    ContainsSubstring("'pair'") && ContainsSubstring("burn"));
  surface.burn.clear();
  surface.triangles[1][2] = 6;
  CHECK_THROWS_WITH(make_draw_list(snapshot),
                    ContainsSubstring("triangle 1") && ContainsSubstring("vertex 6"));
  surface.triangles[1][2] = 5;
  surface.look.detail_size = 0;
  CHECK_THROWS_AS(make_draw_list(snapshot), pbdsurg::InvalidArgument);
}

TEST_CASE("draw list: normals that are given replace those of the triangles", "[unit]") {
  RenderSnapshot snapshot;
  snapshot.surfaces = {two_triangles(0, 0.01f)};
  CHECK(make_draw_list(snapshot).vertices[0].normal == Eigen::Vector3f::UnitZ());
  snapshot.surfaces[0].normals.assign(6, Eigen::Vector3f::UnitX());
  CHECK(make_draw_list(snapshot).vertices[0].normal == Eigen::Vector3f::UnitX());
}

// Would catch a colour that counts beyond its cover where corners of a triangle differ.
TEST_CASE("draw list: a burn's colour is linear and weighed by its cover", "[unit]") {
  RenderSnapshot snapshot;
  snapshot.surfaces = {two_triangles(0, 0.01f)};
  snapshot.surfaces[0].burn.assign(6, Eigen::Vector4f(1, 0, 1, 0.25f));
  snapshot.surfaces[0].burn[1].x() = std::numeric_limits<float>::quiet_NaN();
  const DrawList list = make_draw_list(snapshot);
  CHECK(list.vertices[0].burn == Eigen::Vector4f(0.25f, 0, 0.25f, 0.25f));
  CHECK(list.vertices[1].burn == Eigen::Vector4f::Zero());
}

TEST_CASE("draw list: strands and smoke that show nothing are left out", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector4f color(1, 1, 1, 1);
  RenderSnapshot snapshot;
  snapshot.strands = {{{0, 0, 0}, {0, 0, 0}, color, 0.001f},
                      {{0, 0, 0}, {0, 0, 0.05f}, color, 0.001f},  // along the line of sight
                      {{0, nan, 0}, {0, 0.01f, 0}, color, 0.001f},
                      {{0, 0, 0}, {0.01f, 0, 0}, color, 0.001f}};
  snapshot.smoke = {{{nan, 0, 0}, 0.01f, 0.5f}, {{0, 0, 0}, 0.01f, 0.5f}};

  const DrawList list = make_draw_list(snapshot);

  CHECK(list.tissue.size() == 6);
  CHECK(list.smoke.size() == 6);
}

}  // namespace cholecystectomy
