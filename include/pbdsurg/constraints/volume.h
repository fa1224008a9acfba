// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the volume of a tetrahedron (the paper's equation 2, with the true gradient of the
/// volume).
///
///          x3            C = V - rest volume                     m^3
///         /|\            V = (x1-x0) x (x2-x0) . (x3-x0) / 6
///        / | \           gradient at x3 = (x1-x0) x (x2-x0) / 6  m^2, the others alike
///      x0--|--x2         compliance                              m^5/N
///        \ | /           multiplier                              kg/m
///          x1

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the volume of a tetrahedron: constraints/volume.h has the equations.
struct VolumeConstraint : InPlace<VolumeConstraint> {
  static constexpr int kVertexCount = 4;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 1;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kRest,           ///< m^3
    kStiffness,      ///< fraction, or compliance in m^5/N
    kDamping,        ///< s
    kParameterCount  ///< how many these are
  };

  /// C, in m^3.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[4], Scalar rest_volume) {
    return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / Scalar(6) - rest_volume;
  }

  /// One projection.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param multiplier  kg/m, accumulated
  /// @return            m
  /// Four vertices on one line have no gradient and stay as they are.
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 4> move(const Vec3<Scalar> (&x)[4], const Scalar (&w)[4],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[1],
                                                   [[maybe_unused]] const Damping& damping = {}) {
    const Vec3<Scalar> a = x[1] - x[0];
    const Vec3<Scalar> b = x[2] - x[0];
    const Vec3<Scalar> c = x[3] - x[0];

    // six times the gradients, and of x0 its opposite; the sixth is taken out of C, mobility and
    // move alike
    Vec3<Scalar> g[4];
    g[1] = cross(b, c);
    g[2] = cross(c, a);
    g[3] = cross(a, b);
    g[0] = g[1] + g[2] + g[3];

    const auto sixth = static_cast<Scalar>(1.0 / 6.0);
    const Scalar mobility = sixth * sixth *
                            (w[0] * dot(g[0], g[0]) + w[1] * dot(g[1], g[1]) +
                             w[2] * dot(g[2], g[2]) + w[3] * dot(g[3], g[3]));
    const Scalar value = sixth * dot(a, g[1]) - parameters[kRest];

    Scalar change;
    if constexpr (kMode == ProjectionMode::fraction) {
      change = multiplier_change<kMode>(value, mobility, parameters[kStiffness], multiplier[0]);
    } else if constexpr (kIsDamped<Damping>) {
      const Scalar motion = dot(g[1], x[1] - damping.start[1]) +
                            dot(g[2], x[2] - damping.start[2]) +
                            dot(g[3], x[3] - damping.start[3]) - dot(g[0], x[0] - damping.start[0]);
      change = damped_multiplier_change(
          value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0],
          sixth * motion, parameters[kDamping] * substep.inverse_dt);
    } else {
      change = multiplier_change<kMode>(
          value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0]);
    }
    multiplier[0] = multiplier[0] + change;

    const auto has_direction = is_usable(mobility);
    const Scalar along = sixth * change;
    const Vec3<Scalar> none{};
    return {{select(has_direction, -(w[0] * along) * g[0], none),
             select(has_direction, (w[1] * along) * g[1], none),
             select(has_direction, (w[2] * along) * g[2], none),
             select(has_direction, (w[3] * along) * g[3], none)}};
  }
};

}  // namespace pbdsurg
