// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What devices that are made of others, or of numbers, are checked for.

#include <Eigen/Core>
#include <Eigen/LU>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/device.h"

namespace pbdsurg {

/// Of axes and lengths without unit: far more than rounding and six digits take.
inline constexpr float kAxisTolerance = 1e-3F;

/// Whether axes are of unit length, at right angles and right-handed.
[[nodiscard]] inline bool is_rotation(const Eigen::Matrix3f& axes) noexcept {
  return (axes.transpose() * axes - Eigen::Matrix3f::Identity()).cwiseAbs().maxCoeff() <=
             kAxisTolerance &&
         axes.determinant() > 0;
}

/// @throws InvalidArgument  if it is null
inline void check_device(const Device* device) {
  if (device == nullptr) {
    throw InvalidArgument("a device made of another has none; it must have one");
  }
}

}  // namespace pbdsurg
