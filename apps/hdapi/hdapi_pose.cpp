// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/hdapi_pose.h"

namespace rig {

std::optional<Eigen::Isometry3f> pose_of(std::span<const double, 16> transform) {
  constexpr double kMostError = 0.1;
  const Eigen::Map<const Eigen::Matrix4d> matrix(transform.data());
  const Eigen::Matrix3d axes = matrix.topLeftCorner<3, 3>();
  const double error = (axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm();
  // a comparison with NaN fails
  if (!matrix.allFinite() || !(error < kMostError) || !(axes.determinant() > 0)) {
    return std::nullopt;
  }
  // Gram and Schmidt, beginning with the shaft: its direction is what a tool depends on most
  Eigen::Matrix3d rotation;
  rotation.col(2) = axes.col(2).normalized();
  rotation.col(1) = rotation.col(2).cross(axes.col(0)).normalized();
  rotation.col(0) = rotation.col(1).cross(rotation.col(2));
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.linear() = rotation.cast<float>();
  pose.translation() = (kMetresOfMillimetre * matrix.topRightCorner<3, 1>()).cast<float>();
  return pose;
}

}  // namespace rig
