// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the length of an edge or a link (the paper's equation 1).
///
///     x0 o-----------o x1      C = |x0 - x1| - rest length      m
///                              gradient  +n at x0, -n at x1     1
///                              compliance                       m/N
///                              multiplier                       kg m

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the length of an edge or a link: constraints/distance.h has the equations.
struct DistanceConstraint : InPlace<DistanceConstraint> {
  static constexpr int kVertexCount = 2;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 1;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kRest,           ///< m
    kStiffness,      ///< fraction, or compliance in m/N
    kDamping,        ///< s
    kParameterCount  ///< how many these are
  };

  /// C, in m.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[2], Scalar rest_length) {
    using std::sqrt;
    const Vec3<Scalar> d = x[0] - x[1];
    const Scalar square = dot(d, d);
    // an estimate has no root of zero; what is not a number stays so
    return select(is_usable(square), sqrt(square), square) - rest_length;
  }

  /// One projection.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param multiplier  kg m, accumulated
  /// @return            m
  /// Two vertices at one point have no direction and stay as they are.
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 2> move(const Vec3<Scalar> (&x)[2], const Scalar (&w)[2],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[1],
                                                   [[maybe_unused]] const Damping& damping = {}) {
    using std::sqrt;
    const Vec3<Scalar> d = x[0] - x[1];
    const Scalar length = sqrt(dot(d, d));
    const Scalar value = length - parameters[kRest];
    const Scalar mobility = w[0] + w[1];

    Scalar change;
    if constexpr (kMode == ProjectionMode::fraction) {
      change = multiplier_change<kMode>(value, mobility, parameters[kStiffness], multiplier[0]);
    } else if constexpr (kIsDamped<Damping>) {
      const Vec3<Scalar> moved = d - (damping.start[0] - damping.start[1]);
      change = damped_multiplier_change(
          value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0],
          dot(d, moved) / length, parameters[kDamping] * substep.inverse_dt);
    } else {
      change = multiplier_change<kMode>(
          value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0]);
    }
    const auto has_direction = is_usable(length);
    multiplier[0] = multiplier[0] + select(has_direction, change, Scalar(0));
    const Vec3<Scalar> along = select(has_direction, (change / length) * d, Vec3<Scalar>{});
    return {{w[0] * along, -w[1] * along}};
  }
};

}  // namespace pbdsurg
