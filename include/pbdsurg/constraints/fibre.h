// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Fibres of a tetrahedron, which resist being stretched and nothing else.
///
///     F a = sum over corners of s_k x_k            what a, the unit direction at rest, has become
///     s_k = row k of the inverse rest shape . a    1/m; s_0 = -(s_1 + s_2 + s_3)
///     energy / V0 = k/2 max(0, |F a| - 1)^2        Pa
///     C = max(0, |F a| - 1)                        1
///     gradient    s_k F a / |F a| at corner k      1/m
///     compliance  1 / (k V0)                       1/(N m)
///     multiplier  -C where it is solved, its impulse as a share of k V0 dt^2
///
/// The energy stands beside that of the matrix, as in Weiss, Maker, Govindjee 1996 ("Finite element
/// implementation of incompressible, transversely isotropic hyperelasticity"), whose fibres have no
/// say under compression, either. The multiplier is never positive: fibres pull and do not push.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the fibres of a tetrahedron from being stretched: constraints/fibre.h has the equations.
struct FibreConstraint : InPlace<FibreConstraint> {
  static constexpr int kVertexCount = 4;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 1;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kShares,                   ///< 1/m, s_1 to s_3
    kStiffness = kShares + 3,  ///< k V0, N m, positive
    kParameterCount            ///< how many these are
  };

  /// |F a| - 1, negative where the fibres are slack.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[4],
                                          const Scalar (&parameters)[kParameterCount]) {
    using std::sqrt;
    const Vec3<Scalar> stretched = stretched_fibre(x, parameters);
    return sqrt(dot(stretched, stretched)) - Scalar(1);
  }

  /// One projection, in compliance mode.
  ///
  /// @param x  m
  /// @param w  1/kg, zero for a fixed vertex
  /// @return   m
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 4> move(const Vec3<Scalar> (&x)[4], const Scalar (&w)[4],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[kMultiplierCount],
                                                   const Damping& = {}) {
    using std::sqrt;
    static_assert(kMode == ProjectionMode::compliance, "a stiffness in Pa has no fraction");
    const Scalar s1 = parameters[kShares];
    const Scalar s2 = parameters[kShares + 1];
    const Scalar s3 = parameters[kShares + 2];
    const Scalar s0 = -(s1 + s2 + s3);
    const Vec3<Scalar> stretched = stretched_fibre(x, parameters);
    const Scalar length = sqrt(dot(stretched, stretched));
    const Scalar mobility = w[0] * s0 * s0 + w[1] * s1 * s1 + w[2] * s2 * s2 + w[3] * s3 * s3;
    const Scalar scale = parameters[kStiffness] / substep.inverse_dt_squared;
    const Scalar wanted =
        multiplier[0] - (length - Scalar(1) + multiplier[0]) / (Scalar(1) + scale * mobility);
    const Scalar pull = select(wanted < Scalar(0), wanted, Scalar(0));
    const auto can_move = is_usable(length) & is_usable(mobility);
    const Scalar change = select(can_move, pull - multiplier[0], Scalar(0));
    multiplier[0] = multiplier[0] + change;
    const Vec3<Scalar> along =
        select(can_move, (scale * change / length) * stretched, Vec3<Scalar>{});
    return {{(w[0] * s0) * along, (w[1] * s1) * along, (w[2] * s2) * along, (w[3] * s3) * along}};
  }

 private:
  /// F a
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Vec3<Scalar> stretched_fibre(
      const Vec3<Scalar> (&x)[4], const Scalar (&parameters)[kParameterCount]) {
    return parameters[kShares] * (x[1] - x[0]) + parameters[kShares + 1] * (x[2] - x[0]) +
           parameters[kShares + 2] * (x[3] - x[0]);
  }
};

}  // namespace pbdsurg
