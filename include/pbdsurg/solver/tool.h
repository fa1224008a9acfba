// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Instruments as the solver sees them: rigid sets of capsules that push vertices away.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace pbdsurg {

/// A capsule in the tool's frame; a sphere when both ends coincide.
struct Capsule {
  Eigen::Vector3f start{0, 0, 0};  ///< m
  Eigen::Vector3f end{0, 0, 0};    ///< m
  float radius = 0;                ///< m, positive
};

/// Where a tool is: rotation, then translation, from the tool's frame to the world, in m.
using ToolPose = Eigen::Isometry3f;

}  // namespace pbdsurg
