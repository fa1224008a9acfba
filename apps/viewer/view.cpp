// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

Eigen::Matrix4f look_at(const Eigen::Vector3f& eye, const Eigen::Vector3f& forward,
                        const Eigen::Vector3f& right) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.block<1, 3>(0, 0) = right.transpose();
  matrix.block<1, 3>(1, 0) = right.cross(forward).transpose();
  matrix.block<1, 3>(2, 0) = -forward.transpose();
  matrix.block<3, 1>(0, 3) = -matrix.block<3, 3>(0, 0) * eye;
  return matrix;
}

Eigen::Matrix4f perspective(const Eigen::Vector2f& tangent, float near_plane, float far_plane) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Zero();
  matrix(0, 0) = 1 / tangent.x();
  matrix(1, 1) = 1 / tangent.y();
  matrix(2, 2) = -(far_plane + near_plane) / (far_plane - near_plane);
  matrix(2, 3) = -2 * far_plane * near_plane / (far_plane - near_plane);
  matrix(3, 2) = -1;
  return matrix;
}

void check(const Camera& camera) {
  if (!camera.eye.allFinite() || !camera.target.allFinite() || !camera.up.allFinite() ||
      !camera.light_offset.allFinite() || !std::isfinite(camera.brightness)) {
    throw pbdsurg::InvalidArgument("the camera has a value that is not finite");
  }
  if (!(camera.vertical_field_of_view > 0) || !(camera.vertical_field_of_view < 3.1415f)) {
    throw pbdsurg::InvalidArgument("the camera's vertical field of view is " +
                                   std::to_string(camera.vertical_field_of_view) +
                                   " rad; it must be in (0, pi)");
  }
}

}  // namespace

View make_view(const Camera& camera, float aspect, float farthest) {
  check(camera);
  const Eigen::Vector3f ahead = camera.target - camera.eye;
  const Eigen::Vector3f side = ahead.cross(camera.up);
  // rounding of the cross product, relative to its operands
  if (!(side.norm() > 1e-5f * ahead.norm() * camera.up.norm())) {
    throw pbdsurg::InvalidArgument(
        "the camera's eye and target coincide, or its up vector lies along the view");
  }
  View view;
  view.eye = camera.eye;
  view.reference_distance = ahead.norm();
  const Eigen::Vector3f forward = ahead.normalized();
  const Eigen::Vector3f right = side.normalized();
  const float tangent = std::tan(camera.vertical_field_of_view / 2);
  view.tangent = {aspect * tangent, tangent};
  const float near_plane = 0.02f * view.reference_distance;
  const float far_plane = 1.01f * std::max(farthest, 4 * view.reference_distance);
  view.view_of_world = look_at(camera.eye, forward, right);
  view.clip_of_view = perspective(view.tangent, near_plane, far_plane);

  const Eigen::Vector3f up = right.cross(forward);
  view.light = camera.eye + camera.light_offset.x() * right + camera.light_offset.y() * up -
               camera.light_offset.z() * forward;
  // The lamp looks along the scope, a little wider than the picture.
  const float margin = camera.light_offset.norm() / view.reference_distance;
  const Eigen::Vector2f wider = view.tangent.array() * 1.1f + 2 * margin;
  view.clip_of_world_from_light =
      perspective(wider, near_plane, far_plane) * look_at(view.light, forward, right);
  return view;
}

}  // namespace cholecystectomy
