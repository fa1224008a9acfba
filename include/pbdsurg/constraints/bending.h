// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the angle of a hinge: of two triangles with a common edge.
///
///          x1          theta      from the normal of (x0, x1, x2) to that of (x1, x0, x3), about
///         /|\                     the edge; positive where the surface is convex         rad
///       x2 | x3        C = 4 tan((theta - rest theta) / 4)                               1
///         \|/          gradient   (1 + C^2/16) d theta/dx                                1/m
///          x0          compliance                                                        1/(N m)
///                      multiplier                                                        kg m^2
///
/// For small turns C is the turn in radians. The tangent of a quarter needs no inverse function,
/// has a slope between 1 and 2 up to half a turn either way, and takes any rest angle, as a curved
/// surface has. A hinge that is more than half a turn from rest goes back the shorter way. The
/// gradient of theta is that of Bridson, Marino and Fedkiw 2003 ("Simulation of Clothing with Folds
/// and Wrinkles", section 4).
///
/// The energy of a hinge is k/2 C^2, with the weights of Grinspun et al. 2003 ("Discrete Shells"):
///
///     k = D |e|^2 / (A1 + A2)                                                              N m
///
/// where D is the flexural rigidity, e the edge and A1, A2 the areas, all at rest. With this factor
/// a sheet bent to a cylinder stores D/2 curvature^2 per area: for any axis on equilateral
/// triangles (Seung and Nelson 1988, "Defects in flexible membranes with crystalline order", where
/// k = 2 D / sqrt(3)), along the grid on halved squares. Hinges alone have no second modulus:
/// equilateral triangles bend like a plate with Poisson's ratio -1/3, and halved squares store
/// three times as much when their diagonals bend.
///
/// The hinges of thin sheets have a cheaper form, too: SheetHinge.

#include <cmath>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps the angle of a hinge: constraints/bending.h has the equations.
struct BendingConstraint : InPlace<BendingConstraint> {
  static constexpr int kVertexCount = 4;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 1;  ///< numbers that it accumulates over a substep
  /// What one constraint stores.
  enum Parameter {
    kRest,           ///< 4 tan(rest theta / 4)
    kStiffness,      ///< fraction, or compliance in 1/(N m)
    kDamping,        ///< s
    kParameterCount  ///< how many these are
  };

  /// C, and how it changes with each vertex.
  template <class Scalar>
  struct Turn {
    Scalar value;              ///< C
    Vec3<Scalar> gradient[4];  ///< 1/m
    Scalar curvature[4];       ///< 1/m^2, bounds of the second derivative
  };

  /// How fast a hinge turns, as its friction takes it over a substep: linear in its vertices, from
  /// where they are at the start. d theta = across . sum shares[i] d x_i for any motion of
  /// triangles that keep their shapes, and zero for a rigid one.
  template <class Scalar>
  struct Turning {
    Vec3<Scalar> across;  ///< against both normals, halfway between them
    Scalar shares[4];     ///< 1/m; their sum is zero, and sum shares[i] x_i lies along `across`
  };

  /// C. Zero for a triangle without area, which has no normal.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Scalar value(const Vec3<Scalar> (&x)[4], Scalar rest) {
    const Hinge<Scalar> hinge(x);
    const Scalar none = Scalar(0) * (hinge.square[0] + hinge.square[1]);  // or not a number
    return select(hinge.has_angle(), hinge.turn(rest), none);
  }

  /// C and its derivatives; all zero for a triangle without area or a vertex that is not finite.
  ///
  /// @param x     m
  /// @param rest  4 tan(rest theta / 4)
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Turn<Scalar> turn(const Vec3<Scalar> (&x)[4], Scalar rest) {
    const Hinge<Scalar> hinge(x);
    const auto has_angle = hinge.has_angle();
    const Scalar value = select(has_angle, hinge.turn(rest), Scalar(0));

    // opposite the edge: one over the height of the triangle, against its normal
    const Scalar slope = Scalar(1) + Scalar(0.0625) * (value * value);
    const Scalar rise = -slope * hinge.edge_length;
    const Vec3<Scalar> none{};
    const auto pull_of = [&](int i) {
      return select(has_angle, (rise * hinge.inverse[i]) * hinge.normal[i], none);
    };
    const Vec3<Scalar> left = pull_of(0), right = pull_of(1);
    // on the edge: what cancels force and torque
    const Scalar inverse = select(has_angle, hinge.inverse_edge * hinge.inverse_edge, Scalar(0));
    const auto share_of = [&](const Vec3<Scalar>& opposite) {
      return select(has_angle, inverse * dot(opposite - x[0], hinge.edge), Scalar(0));
    };
    const Scalar left_share = share_of(x[2]), right_share = share_of(x[3]);
    const Vec3<Scalar> end = left_share * left + right_share * right;

    // Found by trial: with this bound no step of a vertex makes C^2 grow, from any shape.
    const Scalar along = slope * inverse;
    const auto square_of = [&](int i) {  // of the pull, over the slope
      const Scalar height = hinge.edge_length * hinge.inverse[i];
      return select(has_angle, slope * (height * height), Scalar(0));
    };
    const Scalar left_square = square_of(0), right_square = square_of(1);
    const auto bound = [&](Scalar a, Scalar b) {
      return a * a * left_square + b * b * right_square + along;
    };
    return {value,
            {end - left - right, Scalar(-1) * end, left, right},
            {bound(Scalar(1) - left_share, Scalar(1) - right_share), bound(left_share, right_share),
             left_square, right_square}};
  }

  /// All zero for a triangle without area or a vertex that is not finite. Beyond a right angle
  /// `across` shrinks, to zero where both triangles lie on each other.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Turning<Scalar> turning(const Vec3<Scalar> (&x)[4]) {
    const Hinge<Scalar> hinge(x);
    const auto has_angle = hinge.has_angle();
    const auto inverse_height = [&](int i) {
      return select(has_angle, hinge.edge_length * hinge.inverse[i], Scalar(0));
    };
    const Scalar inverse = select(has_angle, hinge.inverse_edge * hinge.inverse_edge, Scalar(0));
    const auto foot_of = [&](const Vec3<Scalar>& opposite) {
      return select(has_angle, inverse * dot(opposite - x[0], hinge.edge), Scalar(0));
    };
    const Scalar left = inverse_height(0), right = inverse_height(1);
    const Scalar left_foot = foot_of(x[2]), right_foot = foot_of(x[3]);
    const Vec3<Scalar> sum = hinge.normal[0] + hinge.normal[1];
    const Scalar square = dot(sum, sum);  // 2 at a right angle
    const Scalar scale = Scalar(-2) / select(square > Scalar(2), square, Scalar(2));
    return {select(has_angle, scale * sum, Vec3<Scalar>{}),
            {left * (left_foot - Scalar(1)) + right * (right_foot - Scalar(1)),
             Scalar(-1) * (left * left_foot + right * right_foot), left, right}};
  }

  /// One projection.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param multiplier  kg m^2, accumulated; multiplier / dt^2 is the moment of the hinge, in N m,
  ///                    where C is small
  /// @return            m
  /// Triangles without area have no angle and stay as they are.
  template <ProjectionMode kMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 4> move(const Vec3<Scalar> (&x)[4], const Scalar (&w)[4],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>& substep,
                                                   Scalar (&multiplier)[1],
                                                   [[maybe_unused]] const Damping& damping = {}) {
    const Turn<Scalar> c = turn(x, parameters[kRest]);
    const Vec3<Scalar>(&g)[4] = c.gradient;
    const Scalar mobility = w[0] * dot(g[0], g[0]) + w[1] * dot(g[1], g[1]) +
                            w[2] * dot(g[2], g[2]) + w[3] * dot(g[3], g[3]);

    Scalar change;
    if constexpr (kMode == ProjectionMode::fraction) {
      change = multiplier_change<kMode>(c.value, mobility, parameters[kStiffness], multiplier[0]);
    } else if constexpr (kIsDamped<Damping>) {
      const Scalar motion = dot(g[0], x[0] - damping.start[0]) +
                            dot(g[1], x[1] - damping.start[1]) +
                            dot(g[2], x[2] - damping.start[2]) + dot(g[3], x[3] - damping.start[3]);
      change = damped_multiplier_change(
          c.value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0],
          motion, parameters[kDamping] * substep.inverse_dt);
    } else {
      change = multiplier_change<kMode>(
          c.value, mobility, parameters[kStiffness] * substep.inverse_dt_squared, multiplier[0]);
    }
    multiplier[0] = multiplier[0] + change;

    const auto has_direction = is_usable(mobility);
    const Vec3<Scalar> none{};
    return {{select(has_direction, (w[0] * change) * g[0], none),
             select(has_direction, (w[1] * change) * g[1], none),
             select(has_direction, (w[2] * change) * g[2], none),
             select(has_direction, (w[3] * change) * g[3], none)}};
  }

 private:
  template <class Scalar>
  struct Hinge {
    Vec3<Scalar> edge;
    Scalar edge_square, edge_length, inverse_edge;
    Vec3<Scalar> normal[2];  // unit
    Scalar square[2];        // of twice the areas
    Scalar inverse[2];       // of their roots
    Scalar sine, cosine;     // of theta

    PBDSURG_HOST_DEVICE explicit Hinge(const Vec3<Scalar> (&x)[4]) {
      using std::sqrt;
      edge = x[1] - x[0];
      edge_square = dot(edge, edge);
      edge_length = sqrt(edge_square);
      inverse_edge = Scalar(1) / edge_length;
      const Vec3<Scalar> right = x[3] - x[0];
      normal[0] = cross(edge, x[2] - x[0]);
      normal[1] = cross(right, edge);
      for (int i = 0; i < 2; ++i) {
        square[i] = dot(normal[i], normal[i]);
        inverse[i] = Scalar(1) / sqrt(square[i]);
        normal[i] = inverse[i] * normal[i];
      }
      // the normals' cross product lies along the edge: their volume with it is that of the corners
      sine = -(edge_length * inverse[1]) * dot(normal[0], right);
      cosine = dot(normal[0], normal[1]);
    }

    PBDSURG_HOST_DEVICE auto has_angle() const {
      return is_usable(square[0]) & is_usable(square[1]) & is_usable(edge_square);
    }

    // Along sine and cosine of theta/2 lie those of theta, one of them with 1 added; of both ways
    // to write this, the one without cancellation.
    PBDSURG_HOST_DEVICE Scalar turn(Scalar rest) const {
      using std::sqrt;
      const auto is_blunt = cosine < Scalar(0);
      const Scalar size = select(sine < Scalar(0), -sine, sine);
      const Scalar rest_of_one = Scalar(1) - cosine;
      const Scalar beyond = select(sine < Scalar(0), -rest_of_one, rest_of_one);
      const Scalar half_sine = select(is_blunt, beyond, sine);
      const Scalar half_cosine = select(is_blunt, size, Scalar(1) + cosine);
      const Scalar one_and_cosine =
          half_cosine + sqrt(half_sine * half_sine + half_cosine * half_cosine);
      // tan(theta/4) = half_sine / one_and_cosine, less the rest's: the tangent of the difference,
      // or that of its complement beyond half a turn
      const Scalar across = Scalar(4) * half_sine - rest * one_and_cosine;
      const Scalar along = Scalar(4) * one_and_cosine + rest * half_sine;
      const auto is_beyond = across * across > along * along;
      return Scalar(4) * select(is_beyond, -along, across) / select(is_beyond, across, along);
    }
  };
};

/// A hinge of a thin plate, whose energy is stiffness/2 C^2.
struct HingeAtRest {
  double turn;       ///< BendingConstraint::kRest
  double stiffness;  ///< N m; its inverse is the compliance
};

/// @param x         m, in the order of the picture above
/// @param rigidity  N m, the flexural rigidity D of the plate, positive and finite
/// @throws InvalidArgument  naming the value and the rule, if the rigidity is out of range, a
///                          coordinate is not finite, or the height of a triangle over the hinge's
///                          edge, or that edge, is not more than 1e-6 of the triangle's longest
///                          edge
[[nodiscard]] PBDSURG_API HingeAtRest hinge_at_rest(const Vec3<double> (&x)[4], double rigidity);

/// A hinge whose triangles keep their shapes, as a polynomial of its vertices, without roots. After
/// Bergou et al. 2006, "A Quadratic Bending Model for Inextensible Surfaces", and Garg et al. 2007,
/// "Cubic Shells":
///
///     P = (x2 - foot) / height     across the edge, a unit vector at rest; foot and height are
///                                  those at rest, so that P is a mean of x0, x1 and x2
///     Q                            likewise of x0, x1 and x3
///     cos theta = -P . Q           sin theta = -6 V / (L height height'), V the volume of all four
///
///     E = k/2 (|P|^2 + |Q|^2 + 2 c P . Q + s^2 |e|^2 / L^2) + k s 6 V / (L height height')
///
/// with c and s the cosine and the sine of the angle at rest, e the edge and L its length at rest.
/// This is k (1 - cos(theta - rest theta)) and a constant: k/2 C^2 for small turns, 13 % less at 60
/// degrees from rest and 27 % less at 90, where the moment is the largest. At 180 there is none.
///
/// Stretch bends a flat hinge as far as it differs between both triangles, and takes k s^2 off the
/// stiffness of a bent one. So the sheet has to resist stretch by far more than k.
struct SheetHinge {
  double weights[6];  ///< N/m, of pulls along kTetEdges; some negative, but no sum at a vertex
  double moment;      ///< N/m^2, of the force against the gradient of 6 V; zero if flat

  /// @param x          m, at rest, in the order of the picture above, of triangles with areas
  /// @param stiffness  N m, k
  [[nodiscard]] PBDSURG_API static SheetHinge at_rest(const Vec3<double> (&x)[4], double stiffness);
};

/// The flexural rigidity D of an isotropic thin plate, E t^3 / (12 (1 - nu^2)). See Timoshenko and
/// Woinowsky-Krieger 1959, "Theory of Plates and Shells", eq. 3.
///
/// @param youngs_modulus  Pa, positive and finite
/// @param thickness       m, positive and finite
/// @param poissons_ratio  in (-1, 0.5]
/// @return                N m
/// @throws InvalidArgument  naming the value out of range
[[nodiscard]] PBDSURG_API double flexural_rigidity(double youngs_modulus, double thickness,
                                                   double poissons_ratio);

}  // namespace pbdsurg
