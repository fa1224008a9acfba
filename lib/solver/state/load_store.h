// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Between stored vertices and the vectors of the constraint maths.

#include <Eigen/Core>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/particle.h"

namespace pbdsurg {

template <class Quad>
requires(sizeof(Quad) == sizeof(Particle)) inline Vec3<float> load(const Quad& quad) {
  return {quad.x, quad.y, quad.z};
}
inline Vec3<float> load(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

inline Eigen::Vector3f vector_of(const Vec3<float>& v) {
  return {v.x, v.y, v.z};
}

[[nodiscard]] inline Load gravity_load(const Eigen::Vector3f& gravity) {
  const Vec3<float> g = load(gravity);
  const float square = dot(g, g);
  return {g.x, g.y, g.z, square > 0 ? 1 / square : 0.0F};
}

inline void store(Particle& p, const Vec3<float>& x) {
  p.x = x.x;
  p.y = x.y;
  p.z = x.z;
}

}  // namespace pbdsurg
