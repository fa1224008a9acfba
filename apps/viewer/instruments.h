// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Shapes of the instruments.

#include <Eigen/Geometry>

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// An L-hook: its tip at the origin of the pose, the foot along x, the shaft along z.
[[nodiscard]] Tool draw_hook(const Eigen::Isometry3f& pose);

/// A grasper: its tip at the origin of the pose, the shaft along z, jaws that open along y.
[[nodiscard]] Tool draw_grasper(const Eigen::Isometry3f& pose, bool is_closed);

}  // namespace cholecystectomy
