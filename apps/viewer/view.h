// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From a camera to the matrices that OpenGL wants.

#include <Eigen/Core>

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// A camera, resolved. Views look along -z; lengths are metres.
struct View {
  Eigen::Matrix4f view_of_world;
  Eigen::Matrix4f clip_of_view;
  Eigen::Vector3f eye;
  Eigen::Vector3f light;
  Eigen::Matrix4f clip_of_world_from_light;  ///< for the shadow map
  float reference_distance;                  ///< from the eye to the target
  Eigen::Vector2f tangent;                   ///< of half the field of view, horizontal and vertical
};

/// @param aspect    width / height
/// @param farthest  distance from the eye that must stay visible, m
/// @throws pbdsurg::InvalidArgument  if the camera has no direction or a field of view outside
///         (0, pi), or a value is not finite
[[nodiscard]] View make_view(const Camera& camera, float aspect, float farthest);

}  // namespace cholecystectomy
