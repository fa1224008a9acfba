// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the shape of a tetrahedron of stable Neo-Hookean tissue, whose stiffness is given by
/// moduli.
///
///          x3            F = Ds B      deformation gradient; Ds = [x1-x0, x2-x0, x3-x0], B its
///         /|\                          inverse at rest                                   1
///        / | \           J = det F,  Q = dJ/dF                                           1
///      x0--|--x2         energy/V0 = mu/2 (|F|^2 - 3) + r mu/2 (J - 1 - 1/r)^2           Pa
///        \ | /           stress    = mu (F - (1 + r (1 - J)) Q)                          Pa
///          x1            multiplier  its impulse -stress V0 dt^2, one for each entry of F
///
/// The energy is that of Smith, de Goes and Kim 2018 ("Stable Neo-Hookean Flesh Simulation") in the
/// form of Macklin and Mueller 2021 ("A Constraint-based Formulation of Stable Neo-Hookean
/// Materials"), with r mu = lambda + mu: at small strain its moduli are exactly mu and lambda.
///
/// That paper splits it into two scalar constraints, |F| and J. At rest both pull along F = Q, so
/// what resists shear is the change of their gradients, which XPBD leaves out: the shear force is
/// taken at the start of the substep, whatever the iterations, explodes for stiff tissue and cannot
/// be damped. Here the constraint is the stress itself, all nine entries: one projection is a
/// Newton step of  p = P(F(x)),  p the impulse given so far, in which the stiffness of shear stands
/// as a bound that the direction does not change, for p must turn nothing. The fixed point is
/// implicit Euler's, and every projection goes towards it.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the shape of a tetrahedron, which has moduli: constraints/neo_hookean.h has the equations.
struct NeoHookeanConstraint : InPlace<NeoHookeanConstraint> {
  static constexpr int kVertexCount = 4;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 9;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kInverseShape,                   ///< 1/m, nine entries of B, row by row
    kStiffness = kInverseShape + 9,  ///< mu V0, N m
    kRatio,                          ///< r = 1 / (1 - 2 Poisson's ratio), >= 1
    kDamping,                        ///< s
    kParameterCount                  ///< how many these are
  };

  /// (V - V0) / V0: the volume beyond that at rest, as a share of it.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[4],
                                          const Scalar (&parameters)[kParameterCount]) {
    Vec3<Scalar> f[3], q[3];
    deform(x, parameters, f);
    return cofactors(f, q) - Scalar(1);
  }

  /// One projection, in compliance mode.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param multiplier  impulse, column by column, as a share of mu V0 dt^2
  /// @return            m
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 4> move(const Vec3<Scalar> (&x)[4], const Scalar (&w)[4],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[kMultiplierCount],
                                                   [[maybe_unused]] const Damping& damping = {}) {
    using std::sqrt;
    static_assert(kMode == ProjectionMode::compliance, "moduli have no fraction");
    Vec3<Scalar> f[3], q[3];
    deform(x, parameters, f);
    const Scalar volume = cofactors(f, q);
    const Scalar ratio = parameters[kRatio];
    const Scalar size = Scalar(1.0 / 3.0) * (dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]));
    Scalar pressure = Scalar(1) + ratio * (Scalar(1) - volume);

    // What is left to give, in units of mu V0 dt^2, and the stiffness that resists it as a bound,
    // in units of mu: at rest exactly that of shear, then that of volume.
    Vec3<Scalar> left[3] = {Vec3<Scalar>{multiplier[0], multiplier[1], multiplier[2]} + f[0],
                            Vec3<Scalar>{multiplier[3], multiplier[4], multiplier[5]} + f[1],
                            Vec3<Scalar>{multiplier[6], multiplier[7], multiplier[8]} + f[2]};
    Scalar shear(1);
    Scalar bulk = ratio;
    if constexpr (kIsDamped<Damping>) {
      const Scalar rate = parameters[kDamping] * substep.inverse_dt;
      const Scalar bulk_rate = rate * (ratio - Scalar(1));
      pressure =
          pressure - bulk_rate * add_friction(damping.start, parameters, f, volume, rate, left);
      shear = shear + rate * (Scalar(2) + Scalar(9) * larger(size - Scalar(1), Scalar(0)));
      bulk = bulk + bulk_rate;
    }
    // tension turns what it stiffens, and nothing left does; a little holds strains of hundreds
    shear = shear + larger(pressure, Scalar(-0.03) * pressure) * sqrt(size);
    left[0] = pressure * q[0] - left[0];
    left[1] = pressure * q[1] - left[1];
    left[2] = pressure * q[2] - left[2];

    // mobility of the columns of F, a symmetric matrix
    const Vec3<Scalar> b1 = row(parameters, 0), b2 = row(parameters, 1), b3 = row(parameters, 2);
    const Vec3<Scalar> b0 = Scalar(-1) * (b1 + b2 + b3);
    const Vec3<Scalar> c0 = w[0] * b0, c1 = w[1] * b1, c2 = w[2] * b2, c3 = w[3] * b3;
    const Scalar xx = c0.x * b0.x + c1.x * b1.x + c2.x * b2.x + c3.x * b3.x;
    const Scalar yy = c0.y * b0.y + c1.y * b1.y + c2.y * b2.y + c3.y * b3.y;
    const Scalar zz = c0.z * b0.z + c1.z * b1.z + c2.z * b2.z + c3.z * b3.z;
    const Scalar xy = c0.x * b0.y + c1.x * b1.y + c2.x * b2.y + c3.x * b3.y;
    const Scalar xz = c0.x * b0.z + c1.x * b1.z + c2.x * b2.z + c3.x * b3.z;
    const Scalar yz = c0.y * b0.z + c1.y * b1.z + c2.y * b2.z + c3.y * b3.z;
    const Scalar most =
        larger(xx + magnitude(xy) + magnitude(xz),
               larger(yy + magnitude(xy) + magnitude(yz), zz + magnitude(xz) + magnitude(yz)));

    // The change is f(X) left, X = shear most + bulk Q (Q mobility :) in units of mu V0 dt^2, with
    // eigenvalues z and s. Newton's f is u = 1 / (1 + z); this one is over-relaxed, so that a
    // single projection misses the stress by the square of z only, and leaves -1/2 of the error at
    // worst.
    const Scalar scale = parameters[kStiffness] / substep.inverse_dt_squared;
    const Vec3<Scalar> m0 = xx * q[0] + xy * q[1] + xz * q[2];
    const Vec3<Scalar> m1 = xy * q[0] + yy * q[1] + yz * q[2];
    const Vec3<Scalar> m2 = xz * q[0] + yz * q[1] + zz * q[2];
    const Scalar rise = scale * bulk;
    const Scalar z = scale * (shear * most);
    const Scalar s = z + rise * (dot(m0, q[0]) + dot(m1, q[1]) + dot(m2, q[2]));
    const Scalar u = Scalar(1) / (Scalar(1) + z);
    const Scalar t = Scalar(1) / (Scalar(1) + s);
    const Scalar half(0.5);
    const Scalar across = u * (Scalar(1.5) - half * (u * u));
    const Scalar along = (u * t) * (Scalar(1.5) - half * (u * u + u * t + t * t));
    const Scalar swelling =
        along * (rise * (dot(m0, left[0]) + dot(m1, left[1]) + dot(m2, left[2])));
    const Vec3<Scalar> change0 = across * left[0] - swelling * q[0];
    const Vec3<Scalar> change1 = across * left[1] - swelling * q[1];
    const Vec3<Scalar> change2 = across * left[2] - swelling * q[2];
    const auto is_finite =
        dot(change0, change0) + dot(change1, change1) + dot(change2, change2) < Scalar(kInfinity);
    const Vec3<Scalar> given[3] = {keep(is_finite, change0), keep(is_finite, change1),
                                   keep(is_finite, change2)};
    add(multiplier, given);
    const Vec3<Scalar> d0 = scale * given[0], d1 = scale * given[1], d2 = scale * given[2];
    return {{c0.x * d0 + c0.y * d1 + c0.z * d2, c1.x * d0 + c1.y * d1 + c1.z * d2,
             c2.x * d0 + c2.y * d1 + c2.z * d2, c3.x * d0 + c3.y * d1 + c3.z * d2}};
  }

 private:
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar magnitude(Scalar a) {
    return select(a < Scalar(0), -a, a);
  }
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar larger(Scalar a, Scalar b) {
    return select(a < b, b, a);
  }

  template <class Scalar>
  PBDSURG_HOST_DEVICE static Vec3<Scalar> row(const Scalar (&parameters)[kParameterCount], int i) {
    return {parameters[kInverseShape + 3 * i], parameters[kInverseShape + 3 * i + 1],
            parameters[kInverseShape + 3 * i + 2]};
  }

  template <class Condition, class Scalar>
  PBDSURG_HOST_DEVICE static Vec3<Scalar> keep(const Condition& condition, Vec3<Scalar> v) {
    return {select(condition, v.x, Scalar(0)), select(condition, v.y, Scalar(0)),
            select(condition, v.z, Scalar(0))};
  }

  template <class Scalar>
  PBDSURG_HOST_DEVICE static void add(Scalar (&multiplier)[kMultiplierCount],
                                      const Vec3<Scalar> (&change)[3]) {
    multiplier[0] = multiplier[0] + change[0].x;
    multiplier[1] = multiplier[1] + change[0].y;
    multiplier[2] = multiplier[2] + change[0].z;
    multiplier[3] = multiplier[3] + change[1].x;
    multiplier[4] = multiplier[4] + change[1].y;
    multiplier[5] = multiplier[5] + change[1].z;
    multiplier[6] = multiplier[6] + change[2].x;
    multiplier[7] = multiplier[7] + change[2].y;
    multiplier[8] = multiplier[8] + change[2].z;
  }

  /// Columns of F.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static void deform(const Vec3<Scalar> (&x)[4],
                                         const Scalar (&parameters)[kParameterCount],
                                         Vec3<Scalar> (&f)[3]) {
    const Vec3<Scalar> b1 = row(parameters, 0), b2 = row(parameters, 1), b3 = row(parameters, 2);
    const Vec3<Scalar> a = x[1] - x[0];
    const Vec3<Scalar> b = x[2] - x[0];
    const Vec3<Scalar> c = x[3] - x[0];
    f[0] = b1.x * a + b2.x * b + b3.x * c;
    f[1] = b1.y * a + b2.y * b + b3.y * c;
    f[2] = b1.z * a + b2.z * b + b3.z * c;
  }

  /// @return  J
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar cofactors(const Vec3<Scalar> (&f)[3], Vec3<Scalar> (&q)[3]) {
    q[0] = cross(f[1], f[2]);
    q[1] = cross(f[2], f[0]);
    q[2] = cross(f[0], f[1]);
    return dot(f[0], q[0]);
  }

  /// Inner friction: the rate of F^T F in place of its excess, and likewise of J; a turn changes
  /// neither, however far.
  /// @param pull  grows by that of F^T F
  /// @return      how much J has grown
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar add_friction(const Vec3<Scalar> (&start)[4],
                                                 const Scalar (&parameters)[kParameterCount],
                                                 const Vec3<Scalar> (&f)[3], Scalar volume,
                                                 Scalar rate, Vec3<Scalar> (&pull)[3]) {
    Vec3<Scalar> g[3], unused[3];
    deform(start, parameters, g);
    const Scalar xx = rate * (dot(f[0], f[0]) - dot(g[0], g[0]));
    const Scalar yy = rate * (dot(f[1], f[1]) - dot(g[1], g[1]));
    const Scalar zz = rate * (dot(f[2], f[2]) - dot(g[2], g[2]));
    const Scalar xy = rate * (dot(f[0], f[1]) - dot(g[0], g[1]));
    const Scalar xz = rate * (dot(f[0], f[2]) - dot(g[0], g[2]));
    const Scalar yz = rate * (dot(f[1], f[2]) - dot(g[1], g[2]));
    pull[0] = pull[0] + (xx * f[0] + xy * f[1] + xz * f[2]);
    pull[1] = pull[1] + (xy * f[0] + yy * f[1] + yz * f[2]);
    pull[2] = pull[2] + (xz * f[0] + yz * f[1] + zz * f[2]);
    return volume - cofactors(g, unused);
  }
};

}  // namespace pbdsurg
