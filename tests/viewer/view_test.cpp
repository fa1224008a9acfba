// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/view.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

Eigen::Vector3f project(const View& view, const Eigen::Vector3f& point) {
  const Eigen::Vector4f clip = view.clip_of_view * view.view_of_world * point.homogeneous();
  return clip.head<3>() / clip.w();
}

}  // namespace

TEST_CASE("view: the target is in the middle, up is up, right is right", "[unit]") {
  Camera camera;
  camera.eye = {0.1f, 0.2f, 0.3f};
  camera.target = {0.1f, 0.2f, 0.2f};
  camera.vertical_field_of_view = 2 * std::atan(0.5f);

  const View view = make_view(camera, 2, 0.5f);

  CHECK(project(view, camera.target).head<2>().norm() < 1e-5f);
  // half the field of view spans 0.5 of the distance upwards and, at aspect 2, 1 sideways
  CHECK((project(view, {0.1f, 0.25f, 0.2f}).head<2>() - Eigen::Vector2f(0, 1)).norm() < 1e-4f);
  CHECK((project(view, {0.2f, 0.2f, 0.2f}).head<2>() - Eigen::Vector2f(1, 0)).norm() < 1e-4f);
  CHECK(project(view, {0.1f, 0.2f, 0.25f}).z() < project(view, {0.1f, 0.2f, 0.1f}).z());
  CHECK(std::abs(project(view, {0.1f, 0.2f, -0.2f}).z()) <= 1);  // 0.5 m away is still seen
}

TEST_CASE("view: a camera without a direction is refused", "[unit]") {
  Camera camera;
  camera.target = camera.eye;
  CHECK_THROWS_AS(make_view(camera, 1, 1), pbdsurg::InvalidArgument);
  camera = {};
  camera.up = camera.target - camera.eye;
  CHECK_THROWS_AS(make_view(camera, 1, 1), pbdsurg::InvalidArgument);
  camera = {};
  camera.vertical_field_of_view = 0;
  CHECK_THROWS_WITH(make_view(camera, 1, 1), pbdsurg::testing::ContainsSubstring("field of view"));
  camera = {};
  camera.eye.x() = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(make_view(camera, 1, 1), pbdsurg::InvalidArgument);
}

}  // namespace cholecystectomy
