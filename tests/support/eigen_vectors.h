// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vectors of constraints as those of Eigen, in which tests compute, and back.

#include <Eigen/Core>

#include "pbdsurg/base/vec3.h"

namespace pbdsurg::testing {

inline Vec3<double> to_vec3(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

inline Eigen::Vector3d to_eigen(const Vec3<double>& v) {
  return {v.x, v.y, v.z};
}

}  // namespace pbdsurg::testing
