// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the length of an edge or a link (the paper's eq. 1).
///
///   x0 o-----------o x1      C = |x0 - x1| - rest_length      m
///                            gradient  +n at x0, -n at x1     1
///                            compliance                       m/N
///                            multiplier                       kg m

#include <cmath>

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/vec3.h"

namespace pbdsurg {

struct DistanceConstraint {
  static constexpr int kVertexCount = 2;

  /// C, in m.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[2], Scalar rest_length) {
    using std::sqrt;
    const Vec3<Scalar> d = x[0] - x[1];
    return sqrt(dot(d, d)) - rest_length;
  }

  /// One projection, in place.
  ///
  /// @param x            m
  /// @param w            1/kg, zero for a fixed vertex
  /// @param rest_length  m
  /// @param stiffness    see multiplier_change()
  /// @param multiplier   kg m, accumulated
  /// Two vertices at one point have no direction and stay as they are.
  template <ProjectionMode kMode, class Scalar>
  PBDSURG_HOST_DEVICE static void project(Vec3<Scalar> (&x)[2], const Scalar (&w)[2],
                                          Scalar rest_length, Scalar stiffness,
                                          Scalar& multiplier) {
    using std::sqrt;
    const Vec3<Scalar> d = x[0] - x[1];
    const Scalar length = sqrt(dot(d, d));
    if (!(length > Scalar(0))) {
      return;
    }
    const Scalar change =
        multiplier_change<kMode>(length - rest_length, w[0] + w[1], stiffness, multiplier);
    multiplier += change;
    const Vec3<Scalar> move = (change / length) * d;
    x[0] = x[0] + w[0] * move;
    x[1] = x[1] - w[1] * move;
  }
};

}  // namespace pbdsurg
