// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the shape of a triangle of a membrane, whose stiffness is given by moduli and a thickness.
///
///          x2            F = Ds B      deformation gradient, 3 x 2; Ds = [x1-x0, x2-x0], B the
///         /  \                         inverse at rest of the same in the triangle's plane      1
///        /    \          J = |f1 x f2| the area over that at rest,  Q = dJ/dF                   1
///      x0------x1        energy/A0 = mu t/2 (|F|^2 - 2) + r mu t/2 (J - 1 - 1/r)^2            N/m
///                        stress    = mu t (F - (1 + r (1 - J)) Q)                             N/m
///                        multiplier  its impulse -stress A0 dt^2, one for each entry of F
///
/// It is the energy of constraints/neo_hookean.h (Smith, de Goes and Kim 2018, "Stable Neo-Hookean
/// Flesh Simulation") in the two dimensions of the sheet, with t its thickness and r such that at
/// small strain the moduli are exactly those of plane stress (Timoshenko and Goodier 1951, "Theory
/// of Elasticity", section 9): mu = E / (2 (1 + nu)), r = (1 + nu) / (1 - nu). At large stretch it
/// differs from a solid that gets thinner. J has no sign: in space a triangle cannot be inverted,
/// and no shape has an infinite energy. Compressed, it buckles; what stops that is bending.
///
/// The projection is that of a tetrahedron, with its bounds: a Newton step of  p = P(F(x)).

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the shape of a triangle of a membrane: constraints/membrane.h has the equations.
struct MembraneConstraint : InPlace<MembraneConstraint> {
  static constexpr int kVertexCount = 3;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 6;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kInverseShape,                   ///< 1/m, four entries of B, row by row
    kStiffness = kInverseShape + 4,  ///< mu t A0, N m
    kRatio,                          ///< r = (1 + Poisson's ratio) / (1 - Poisson's ratio), >= 1
    kDamping,                        ///< s
    kParameterCount                  ///< how many these are
  };

  /// (A - A0) / A0: the area beyond that at rest, as a share of it.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[3],
                                          const Scalar (&parameters)[kParameterCount]) {
    Vec3<Scalar> f[2], q[2];
    deform(x, parameters, f);
    return cofactors(f, q) - Scalar(1);
  }

  /// One projection, in compliance mode.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param multiplier  impulse, column by column, as a share of mu t A0 dt^2
  /// @return            m
  /// A triangle without area has no plane: it is drawn together, as far as its edges are too long.
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 3> move(const Vec3<Scalar> (&x)[3], const Scalar (&w)[3],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[kMultiplierCount],
                                                   [[maybe_unused]] const Damping& damping = {}) {
    using std::sqrt;
    static_assert(kMode == ProjectionMode::compliance, "moduli have no fraction");
    Vec3<Scalar> f[2], q[2];
    deform(x, parameters, f);
    const Scalar area = cofactors(f, q);
    const Scalar ratio = parameters[kRatio];
    const Scalar size = Scalar(0.5) * (dot(f[0], f[0]) + dot(f[1], f[1]));
    Scalar pressure = Scalar(1) + ratio * (Scalar(1) - area);

    // What is left to give, in units of mu t A0 dt^2, and the stiffness that resists it as a bound,
    // in units of mu t: at rest exactly that of shear, then that of area.
    Vec3<Scalar> left[2] = {Vec3<Scalar>{multiplier[0], multiplier[1], multiplier[2]} + f[0],
                            Vec3<Scalar>{multiplier[3], multiplier[4], multiplier[5]} + f[1]};
    Scalar shear(1);
    Scalar bulk = ratio;
    if constexpr (kIsDamped<Damping>) {
      const Scalar rate = parameters[kDamping] * substep.inverse_dt;
      const Scalar bulk_rate = rate * (ratio - Scalar(1));
      pressure =
          pressure - bulk_rate * add_friction(damping.start, parameters, f, area, rate, left);
      shear = shear + rate * (Scalar(2) + Scalar(9) * larger(size - Scalar(1), Scalar(0)));
      bulk = bulk + bulk_rate;
    }
    // both ways: under tension the plane of the sheet is what turns
    shear = shear + larger(pressure, -pressure) * sqrt(size);
    left[0] = pressure * q[0] - left[0];
    left[1] = pressure * q[1] - left[1];

    // mobility of the columns of F, a symmetric matrix
    const Scalar x1 = parameters[kInverseShape], y1 = parameters[kInverseShape + 1];
    const Scalar x2 = parameters[kInverseShape + 2], y2 = parameters[kInverseShape + 3];
    const Scalar x0 = -(x1 + x2), y0 = -(y1 + y2);
    const Scalar xx = w[0] * (x0 * x0) + w[1] * (x1 * x1) + w[2] * (x2 * x2);
    const Scalar yy = w[0] * (y0 * y0) + w[1] * (y1 * y1) + w[2] * (y2 * y2);
    const Scalar xy = w[0] * (x0 * y0) + w[1] * (x1 * y1) + w[2] * (x2 * y2);
    const Scalar most = larger(xx, yy) + larger(xy, -xy);

    // The change is f(X) left, as of a tetrahedron: see constraints/neo_hookean.h.
    const Scalar scale = parameters[kStiffness] / substep.inverse_dt_squared;
    const Vec3<Scalar> m0 = xx * q[0] + xy * q[1];
    const Vec3<Scalar> m1 = xy * q[0] + yy * q[1];
    const Scalar rise = scale * bulk;
    const Scalar z = scale * (shear * most);
    const Scalar s = z + rise * (dot(m0, q[0]) + dot(m1, q[1]));
    const Scalar u = Scalar(1) / (Scalar(1) + z);
    const Scalar t = Scalar(1) / (Scalar(1) + s);
    const Scalar half(0.5);
    const Scalar across = u * (Scalar(1.5) - half * (u * u));
    const Scalar along = (u * t) * (Scalar(1.5) - half * (u * u + u * t + t * t));
    const Scalar swelling = along * (rise * (dot(m0, left[0]) + dot(m1, left[1])));
    const Vec3<Scalar> change0 = across * left[0] - swelling * q[0];
    const Vec3<Scalar> change1 = across * left[1] - swelling * q[1];
    const auto is_finite = dot(change0, change0) + dot(change1, change1) < Scalar(kInfinity);
    const Vec3<Scalar> none{};
    const Vec3<Scalar> given0 = select(is_finite, change0, none);
    const Vec3<Scalar> given1 = select(is_finite, change1, none);
    multiplier[0] = multiplier[0] + given0.x;
    multiplier[1] = multiplier[1] + given0.y;
    multiplier[2] = multiplier[2] + given0.z;
    multiplier[3] = multiplier[3] + given1.x;
    multiplier[4] = multiplier[4] + given1.y;
    multiplier[5] = multiplier[5] + given1.z;
    const Vec3<Scalar> d0 = scale * given0, d1 = scale * given1;
    return {{w[0] * (x0 * d0 + y0 * d1), w[1] * (x1 * d0 + y1 * d1), w[2] * (x2 * d0 + y2 * d1)}};
  }

 private:
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar larger(Scalar a, Scalar b) {
    return select(a < b, b, a);
  }

  /// Columns of F.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static void deform(const Vec3<Scalar> (&x)[3],
                                         const Scalar (&parameters)[kParameterCount],
                                         Vec3<Scalar> (&f)[2]) {
    const Vec3<Scalar> a = x[1] - x[0];
    const Vec3<Scalar> b = x[2] - x[0];
    f[0] = parameters[kInverseShape] * a + parameters[kInverseShape + 2] * b;
    f[1] = parameters[kInverseShape + 1] * a + parameters[kInverseShape + 3] * b;
  }

  /// @return  J; without area, Q is zero
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar cofactors(const Vec3<Scalar> (&f)[2], Vec3<Scalar> (&q)[2]) {
    using std::sqrt;
    const Vec3<Scalar> normal = cross(f[0], f[1]);
    const Scalar square = dot(normal, normal);
    const auto has_area = is_usable(square);
    const Scalar area = select(has_area, sqrt(square), Scalar(0) * square);
    const Scalar inverse = select(has_area, Scalar(1) / area, Scalar(0));
    q[0] = inverse * cross(f[1], normal);
    q[1] = inverse * cross(normal, f[0]);
    return area;
  }

  /// Inner friction: the rate of F^T F in place of its excess, and likewise of J; a turn changes
  /// neither, however far.
  /// @param pull  grows by that of F^T F
  /// @return      how much J has grown
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar add_friction(const Vec3<Scalar> (&start)[3],
                                                 const Scalar (&parameters)[kParameterCount],
                                                 const Vec3<Scalar> (&f)[2], Scalar area,
                                                 Scalar rate, Vec3<Scalar> (&pull)[2]) {
    Vec3<Scalar> g[2], unused[2];
    deform(start, parameters, g);
    const Scalar xx = rate * (dot(f[0], f[0]) - dot(g[0], g[0]));
    const Scalar yy = rate * (dot(f[1], f[1]) - dot(g[1], g[1]));
    const Scalar xy = rate * (dot(f[0], f[1]) - dot(g[0], g[1]));
    pull[0] = pull[0] + (xx * f[0] + xy * f[1]);
    pull[1] = pull[1] + (xy * f[0] + yy * f[1]);
    return area - cofactors(g, unused);
  }
};

}  // namespace pbdsurg
