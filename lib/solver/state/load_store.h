// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Between stored vertices and the vectors of the constraint maths.

#include <Eigen/Core>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/particle.h"

namespace pbdsurg {

inline Vec3<float> load(const Particle& p) {
  return {p.x, p.y, p.z};
}
inline Vec3<float> load(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

inline void store(Particle& p, const Vec3<float>& x) {
  p.x = x.x;
  p.y = x.y;
  p.z = x.z;
}

}  // namespace pbdsurg
