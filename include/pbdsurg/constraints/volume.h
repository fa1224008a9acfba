// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the volume of a tetrahedron (the paper's eq. 2, with the true gradient of the volume).
///
///          x3            C = V - rest_volume                     m^3
///         /|\            V = (x1-x0) x (x2-x0) . (x3-x0) / 6
///        / | \           gradient at x3 = (x1-x0) x (x2-x0) / 6  m^2, the others alike
///      x0--|--x2         compliance                              m^5/N
///        \ | /           multiplier                              kg/m
///          x1

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/vec3.h"

namespace pbdsurg {

struct VolumeConstraint {
  static constexpr int kVertexCount = 4;

  /// C, in m^3.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[4], Scalar rest_volume) {
    return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / Scalar(6) - rest_volume;
  }

  /// One projection, in place.
  ///
  /// @param x            m
  /// @param w            1/kg, zero for a fixed vertex
  /// @param rest_volume  m^3
  /// @param stiffness    see multiplier_change()
  /// @param multiplier   kg/m, accumulated
  /// Four vertices on one line have no gradient and stay as they are.
  template <ProjectionMode kMode, class Scalar>
  PBDSURG_HOST_DEVICE static void project(Vec3<Scalar> (&x)[4], const Scalar (&w)[4],
                                          Scalar rest_volume, Scalar stiffness,
                                          Scalar& multiplier) {
    const Vec3<Scalar> a = x[1] - x[0];
    const Vec3<Scalar> b = x[2] - x[0];
    const Vec3<Scalar> c = x[3] - x[0];

    // six times the gradients; the sixth is taken out of C, mobility and move alike
    const Vec3<Scalar> g1 = cross(b, c);
    const Vec3<Scalar> g2 = cross(c, a);
    const Vec3<Scalar> g3 = cross(a, b);
    const Vec3<Scalar> g0 = Scalar(-1) * (g1 + g2 + g3);

    constexpr Scalar kSixth = Scalar(1) / Scalar(6);
    const Scalar mobility =
        kSixth * kSixth *
        (w[0] * dot(g0, g0) + w[1] * dot(g1, g1) + w[2] * dot(g2, g2) + w[3] * dot(g3, g3));
    const Scalar change = multiplier_change<kMode>(kSixth * dot(a, g1) - rest_volume, mobility,
                                                   stiffness, multiplier);
    multiplier += change;

    const Scalar move = kSixth * change;
    x[0] = x[0] + (w[0] * move) * g0;
    x[1] = x[1] + (w[1] * move) * g1;
    x[2] = x[2] + (w[2] * move) * g2;
    x[3] = x[3] + (w[3] * move) * g3;
  }
};

}  // namespace pbdsurg
