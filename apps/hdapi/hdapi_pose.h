// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// HDAPI's millimetres and matrices as metres and poses.

#include <Eigen/Geometry>
#include <optional>
#include <span>

namespace rig {

inline constexpr double kMetresOfMillimetre = 1e-3;

/// The pose in a transform of HDAPI, whose axes are unit and orthogonal to a few digits only.
/// @param transform  [16] by columns, translation in 12 to 14, mm
/// @return  m, with a rotation that is one to float precision; nothing where a number is not finite
///          or the axes are more than a tenth from a rotation
[[nodiscard]] std::optional<Eigen::Isometry3f> pose_of(std::span<const double, 16> transform);

}  // namespace rig
