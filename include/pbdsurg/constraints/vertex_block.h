// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Moves one vertex to the least energy that its neighbours leave it. After Chen et al. 2024,
/// "Vertex Block Descent".
///
///            o            E(x) = m / (2 h^2) |x - y|^2     inertia; y is where it flies by itself
///          / | \                + sum w/2 |x_j - x|^2      distortion of Neo-Hookean tetrahedra
///        o---x---o              + sum k/2 (l - rest)^2     springs; limits of stretch, if longer
///          \ | /                + sum s/2 (V - target)^2   volumes
///            o                  + sum k/2 C^2             hinges (constraints/bending.h)
///                               + sum w/2 |x_j - x|^2      those of thin sheets (SheetHinge)
///                               + sum m 6 V
///                               + sum 1/2 turn^2          friction of hinges, in a substep
///                               + sum w/2 |x_j - x|^2      triangles of sheets, likewise
///                               + sum a/2 (A - target)^2
///                               + sum s/2 max(0, |F a| - 1)^2   fibres (constraints/fibre.h)
///
/// A stable Neo-Hookean tetrahedron (Smith, de Goes, Kim 2018) stores, per rest volume V0,
///
///     mu/2 (tr(F^T F) - 3) + lambda/2 (J - 1 - mu/lambda)^2,  lambda = lambda_Lame + mu,
///
/// whose moduli at rest are those asked for. F is linear in the vertices, so the first term is a
/// sum over edges with constant weights; the second is a volume term. Both are quadratic in one
/// vertex: the step is exact, and the energy never grows, whatever the deformation.
///
/// A triangle of a sheet (constraints/membrane.h) is the same in two dimensions: edges and an area.
/// Within its plane that is quadratic in one vertex. Across, the area resists with a tension that
/// takes back what the edges give at rest, and more under compression, where the sheet is to
/// buckle. Of this curvature the magnitude stands in the Hessian (Chen et al. 2024, "Stabler
/// Neo-Hookean Simulation: Absolute Eigenvalue Filtering for Projected Newton").

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// What a Neo-Hookean tetrahedron adds to the energy of its vertices.
template <class Scalar>
struct NeoHookeanTerms {
  Scalar weights[6];  ///< N/m, of the edges in the order of kTetEdges; negative at obtuse angles
  Scalar stiffness;   ///< N/m^5, of the volume
  Scalar target;      ///< m^3, the volume that it strives for against the pull of its edges

  /// @param x       m, at rest, of positive volume
  /// @param mu      Pa, the shear modulus
  /// @param lambda  Pa, Lame's first parameter + mu
  static NeoHookeanTerms at_rest(const Vec3<Scalar> (&x)[4], Scalar mu, Scalar lambda) {
    const Vec3<Scalar> a = x[1] - x[0];
    const Vec3<Scalar> b = x[2] - x[0];
    const Vec3<Scalar> c = x[3] - x[0];
    // six times the gradients of the volume, which are the rows of the inverse rest shape too
    const Vec3<Scalar> g1 = cross(b, c);
    const Vec3<Scalar> g2 = cross(c, a);
    const Vec3<Scalar> g3 = cross(a, b);
    const Vec3<Scalar> g0 = Scalar(-1) * (g1 + g2 + g3);
    const Scalar volume = dot(a, g1) / Scalar(6);
    const Scalar scale = -mu / (Scalar(36) * volume);
    return {{scale * dot(g0, g1), scale * dot(g0, g2), scale * dot(g0, g3), scale * dot(g1, g2),
             scale * dot(g1, g3), scale * dot(g2, g3)},
            lambda / volume,
            volume * (Scalar(1) + mu / lambda)};
  }

  /// Of a tetrahedron that is larger at rest, in all directions alike.
  /// @param ratio  of the rest volumes
  [[nodiscard]] NeoHookeanTerms resized(Scalar ratio) const {
    using std::cbrt;
    const Scalar scale = cbrt(ratio);
    NeoHookeanTerms terms = *this;
    for (Scalar& weight : terms.weights) {
      weight = scale * weight;
    }
    terms.stiffness = stiffness / ratio;
    terms.target = target * ratio;
    return terms;
  }
};

/// What a triangle of a sheet adds to the energy of its vertices.
template <class Scalar>
struct MembraneTerms {
  Scalar weights[3];  ///< N/m, of the edges opposite the vertices; negative at obtuse angles
  Scalar stiffness;   ///< N/m^3, of the area
  Scalar target;      ///< m^2, the area that it strives for against the pull of its edges

  /// @param x       m, at rest, of positive area
  /// @param mu      N/m, the shear modulus times the thickness
  /// @param lambda  N/m, r mu of constraints/membrane.h
  static MembraneTerms at_rest(const Vec3<Scalar> (&x)[3], Scalar mu, Scalar lambda) {
    using std::sqrt;
    const Vec3<Scalar> sides[3] = {x[2] - x[1], x[0] - x[2], x[1] - x[0]};
    const Vec3<Scalar> normal = cross(sides[0], sides[1]);
    const Scalar area = sqrt(dot(normal, normal)) / Scalar(2);
    const Scalar scale = -mu / (Scalar(4) * area);
    return {{scale * dot(sides[1], sides[2]), scale * dot(sides[2], sides[0]),
             scale * dot(sides[0], sides[1])},
            lambda / area,
            area * (Scalar(1) + mu / lambda)};
  }
};

/// The area of a triangle as one of its vertices sees it.
template <class Scalar>
struct AreaPull {
  Vec3<Scalar> normal;    ///< m^2, of a length of twice the area
  Vec3<Scalar> edge;      ///< m, the one opposite
  Scalar inverse_square;  ///< 1/m^4, of that length; zero of a triangle without area
  Scalar area;            ///< m^2
  Vec3<Scalar> gradient;  ///< m, of the area

  /// @param a  m, with b: the edge opposite, from the vertex
  PBDSURG_HOST_DEVICE AreaPull(const Vec3<Scalar>& a, const Vec3<Scalar>& b)
      : normal(cross(a, b)), edge(b - a) {
    using std::sqrt;
    const Scalar square = dot(normal, normal);
    const auto has_area = is_usable(square);
    const Scalar length = select(has_area, sqrt(square), Scalar(0));
    inverse_square = select(has_area, Scalar(1) / square, Scalar(0));
    area = Scalar(0.5) * length;
    gradient = (Scalar(0.5) * length * inverse_square) * cross(normal, edge);
  }
};

/// A spring as one of its ends sees it.
template <class Scalar>
struct SpringPull {
  Vec3<Scalar> n;    ///< along it; zero where both ends are at one point
  Scalar inverse;    ///< 1/m, of its length
  Scalar stretch;    ///< m, beyond the rest length
  Scalar rest;       ///< m
  Scalar stiffness;  ///< N/m; zero of a limit that it does not reach

  /// @param given  N/m, >= 0
  /// @param ends   m, its rest length; negative: a limit, which pulls only what is longer than that
  /// @param d      m, from the vertex to the other end; at one point it has no direction
  PBDSURG_HOST_DEVICE SpringPull(Scalar given, Scalar ends, const Vec3<Scalar>& d) {
    using std::sqrt;
    const Scalar length = sqrt(dot(d, d));
    const auto has_direction = is_usable(length);
    inverse = select(has_direction, Scalar(1) / length, Scalar(0));
    n = inverse * d;
    const auto is_limit = ends < Scalar(0);
    rest = select(is_limit, -ends, ends);
    stiffness = select(is_limit, select(length > rest, given, Scalar(0)), given);
    stretch = select(has_direction, length - rest, Scalar(0));
  }
};

/// The force on one vertex: what explicit steps need of the energy below.
template <class Scalar>
struct VertexForce {
  using Number = Scalar;                  ///< what it is made of
  static constexpr bool kHasMore = true;  ///< whether more than volumes adds to it

  Vec3<Scalar> force;  ///< N

  /// What others have found.
  PBDSURG_HOST_DEVICE void add(const VertexForce& other) { force = force + other.force; }

  /// As VertexEnergy::add_pull().
  PBDSURG_HOST_DEVICE void add_pull(Scalar stiffness, const Vec3<Scalar>& d) {
    force = force + stiffness * d;
  }
  /// As VertexEnergy::add_spring().
  PBDSURG_HOST_DEVICE void add_spring(Scalar given, Scalar ends, const Vec3<Scalar>& d) {
    const SpringPull<Scalar> pull(given, ends, d);
    force = force + (pull.stiffness * pull.stretch) * pull.n;
  }
  /// As VertexEnergy::add_fibre().
  PBDSURG_HOST_DEVICE void add_fibre(Scalar given, Scalar share, const Vec3<Scalar>& stretched) {
    const SpringPull<Scalar> pull(given, Scalar(-1), stretched);
    force = force + (share * (pull.stiffness * pull.stretch)) * pull.n;
  }
  /// As VertexEnergy::add_volume().
  PBDSURG_HOST_DEVICE void add_volume(Scalar stiffness, Scalar target, const Vec3<Scalar>& a,
                                      const Vec3<Scalar>& b, const Vec3<Scalar>& c) {
    const Vec3<Scalar> face = cross(b - a, c - a);
    force = force + (stiffness * (dot(a, face) - target)) * face;
  }
  /// As VertexEnergy::add_hinge().
  template <class Condition>
  PBDSURG_HOST_DEVICE void add_hinge(Scalar stiffness, Scalar rest, const Vec3<Scalar> (&x)[4],
                                     const Condition& is_opposite) {
    const auto turn = BendingConstraint::turn(x, rest);
    const Vec3<Scalar>&opposite = turn.gradient[2], &on_edge = turn.gradient[0];
    const Vec3<Scalar> gradient{select(is_opposite, opposite.x, on_edge.x),
                                select(is_opposite, opposite.y, on_edge.y),
                                select(is_opposite, opposite.z, on_edge.z)};
    force = force - (stiffness * turn.value) * gradient;
  }
  /// As VertexEnergy::add_moment().
  PBDSURG_HOST_DEVICE void add_moment(Scalar moment, const Vec3<Scalar>& a, const Vec3<Scalar>& b,
                                      const Vec3<Scalar>& c) {
    force = force + moment * cross(b - a, c - a);
  }
  /// As VertexEnergy::add_friction().
  PBDSURG_HOST_DEVICE void add_friction(Scalar share, const Vec3<Scalar>& across, Scalar turn) {
    force = force + (share * turn) * across;
  }
  /// As VertexEnergy::add_triangle().
  PBDSURG_HOST_DEVICE void add_triangle(Scalar weight_a, Scalar weight_b, Scalar stiffness,
                                        Scalar target, const Vec3<Scalar>& a,
                                        const Vec3<Scalar>& b) {
    add_pull(weight_a, a);
    add_pull(weight_b, b);
    add_area(weight_a + weight_b, stiffness, target, a, b);
  }
  /// As VertexEnergy::add_area().
  PBDSURG_HOST_DEVICE void add_area(Scalar /*within*/, Scalar stiffness, Scalar target,
                                    const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
    const AreaPull<Scalar> pull(a, b);
    force = force + (stiffness * (target - pull.area)) * pull.gradient;
  }
};

/// The energy around one vertex to second order, at the place where it is.
template <class Scalar>
struct VertexEnergy {
  using Number = Scalar;                  ///< what it is made of
  static constexpr bool kHasMore = true;  ///< whether more than volumes adds to it

  Vec3<Scalar> force;  ///< N, minus the gradient
  Scalar isotropic{};  ///< N/m; the Hessian is isotropic * I + the six numbers below, which alone
                       ///< are positive semidefinite
  Scalar xx{},         ///< N/m
      yy{},            ///< N/m
      zz{},            ///< N/m
      xy{},            ///< N/m
      xz{},            ///< N/m
      yz{};            ///< N/m

  /// What others have found.
  PBDSURG_HOST_DEVICE void add(const VertexEnergy& other) {
    force = force + other.force;
    isotropic = isotropic + other.isotropic;
    xx = xx + other.xx;
    yy = yy + other.yy;
    zz = zz + other.zz;
    xy = xy + other.xy;
    xz = xz + other.xz;
    yz = yz + other.yz;
  }

  /// Stiffness towards a point: inertia, the distortion of tetrahedra, a soft grasp.
  /// @param stiffness  N/m
  /// @param d          m, from the vertex to the point
  PBDSURG_HOST_DEVICE void add_pull(Scalar stiffness, const Vec3<Scalar>& d) {
    force = force + stiffness * d;
    isotropic = isotropic + stiffness;
  }

  /// A spring. Under compression its Hessian is not definite; what is negative is left out.
  /// @param given  N/m, >= 0
  /// @param ends   m, its rest length; negative: a limit, which pulls only what is longer than that
  /// @param d      m, from the vertex to the other end; at one point it has no direction
  PBDSURG_HOST_DEVICE void add_spring(Scalar given, Scalar ends, const Vec3<Scalar>& d) {
    const SpringPull<Scalar> pull(given, ends, d);
    const Scalar slack = Scalar(1) - pull.rest * pull.inverse;
    const Scalar across = pull.stiffness * select(slack > Scalar(0), slack, Scalar(0));
    force = force + (pull.stiffness * pull.stretch) * pull.n;
    isotropic = isotropic + across;
    add_square(pull.stiffness - across, pull.n);
  }

  /// The fibres of a tetrahedron: a limit of length 1 to F a, which the vertex moves by its share.
  /// @param given      N m, >= 0, k V0 of constraints/fibre.h
  /// @param share      1/m, minus the vertex's own: the sum of those of the others
  /// @param stretched  F a
  PBDSURG_HOST_DEVICE void add_fibre(Scalar given, Scalar share, const Vec3<Scalar>& stretched) {
    const SpringPull<Scalar> pull(given, Scalar(-1), stretched);
    const Scalar along = share * share * pull.stiffness;
    const Scalar slack = Scalar(1) - pull.inverse;
    const Scalar across = along * select(slack > Scalar(0), slack, Scalar(0));
    force = force + (share * (pull.stiffness * pull.stretch)) * pull.n;
    isotropic = isotropic + across;
    add_square(along - across, pull.n);
  }

  /// The volume of a tetrahedron.
  /// @param stiffness  N/m^5 / 36, >= 0
  /// @param target     6 m^3
  /// @param a          m, with b and c: the face opposite, from the vertex, counter-clockwise seen
  ///                   from outside
  PBDSURG_HOST_DEVICE void add_volume(Scalar stiffness, Scalar target, const Vec3<Scalar>& a,
                                      const Vec3<Scalar>& b, const Vec3<Scalar>& c) {
    // minus six times the gradient of the volume
    const Vec3<Scalar> face = cross(b - a, c - a);
    force = force + (stiffness * (dot(a, face) - target)) * face;
    add_square(stiffness, face);
  }

  /// The angle of a hinge. Its Hessian is not definite; a bound stands for the second derivative of
  /// the angle, so that no step makes the hinge's energy grow.
  /// @param stiffness    N m, >= 0
  /// @param rest         BendingConstraint::kRest
  /// @param x            m, in the order of BendingConstraint, the vertex first or third: turned by
  ///                     half a turn, a hinge is the same
  /// @param is_opposite  whether it is the third, opposite the edge
  template <class Condition>
  PBDSURG_HOST_DEVICE void add_hinge(Scalar stiffness, Scalar rest, const Vec3<Scalar> (&x)[4],
                                     const Condition& is_opposite) {
    const auto turn = BendingConstraint::turn(x, rest);
    const Vec3<Scalar>&opposite = turn.gradient[2], &on_edge = turn.gradient[0];
    const Vec3<Scalar> gradient{select(is_opposite, opposite.x, on_edge.x),
                                select(is_opposite, opposite.y, on_edge.y),
                                select(is_opposite, opposite.z, on_edge.z)};
    const Scalar curvature = select(is_opposite, turn.curvature[2], turn.curvature[0]);
    const Scalar moment = stiffness * turn.value;
    force = force - moment * gradient;
    isotropic = isotropic + select(moment < Scalar(0), -moment, moment) * curvature;
    add_square(stiffness, gradient);
  }

  /// What the hinge of a thin sheet that is bent at rest adds to pulls: linear in one vertex.
  /// @param moment  N/m^2, of SheetHinge; its sign that of the order of the others
  /// @param a       m, with b and c: the others
  PBDSURG_HOST_DEVICE void add_moment(Scalar moment, const Vec3<Scalar>& a, const Vec3<Scalar>& b,
                                      const Vec3<Scalar>& c) {
    force = force + moment * cross(b - a, c - a);
  }

  /// The friction of a hinge, 1/2 turn^2 with BendingConstraint::Turning of the substep's start.
  /// @param share   1/m, minus the vertex's own: the sum of those of the others
  /// @param across  sqrt(N m)
  /// @param turn    sqrt(N m), of the hinge since then
  PBDSURG_HOST_DEVICE void add_friction(Scalar share, const Vec3<Scalar>& across, Scalar turn) {
    force = force + (share * turn) * across;
    add_square(share * share, across);
  }

  /// A triangle of a sheet.
  /// @param weight_a   N/m, of the pull towards a
  /// @param weight_b   N/m, likewise; their sum is not negative
  /// @param stiffness  N/m^3, >= 0
  /// @param target     m^2
  /// @param a          m, with b: the edge opposite, from the vertex
  PBDSURG_HOST_DEVICE void add_triangle(Scalar weight_a, Scalar weight_b, Scalar stiffness,
                                        Scalar target, const Vec3<Scalar>& a,
                                        const Vec3<Scalar>& b) {
    add_pull(weight_a, a);
    add_pull(weight_b, b);
    add_area(weight_a + weight_b, stiffness, target, a, b);
  }

  /// What a triangle adds to its pulls. The curvature of its energy across its plane counts by its
  /// magnitude.
  /// @param within  N/m, the sum of the weights of its pulls
  PBDSURG_HOST_DEVICE void add_area(Scalar within, Scalar stiffness, Scalar target,
                                    const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
    const AreaPull<Scalar> pull(a, b);
    const Scalar tension = stiffness * (pull.area - target);
    force = force - tension * pull.gradient;
    const Scalar edge_square = dot(pull.edge, pull.edge);
    const Scalar turned = within + tension * pull.area * edge_square * pull.inverse_square;
    const Scalar across = select(turned < Scalar(0), -turned, turned);
    const Scalar least = select(across < within, across, within);
    const Scalar rest = within - least;
    isotropic = isotropic - rest;
    xx = xx + rest;
    yy = yy + rest;
    zz = zz + rest;
    add_square((across - within) * pull.inverse_square, pull.normal);
    add_square(stiffness, pull.gradient);
  }

  /// Adds a stiffness along a direction to the Hessian alone.
  /// @param stiffness  N/m of a unit direction
  /// @param g          the direction
  PBDSURG_HOST_DEVICE void add_square(Scalar stiffness, const Vec3<Scalar>& g) {
    const Vec3<Scalar> s = stiffness * g;
    xx = xx + s.x * g.x;
    yy = yy + s.y * g.y;
    zz = zz + s.z * g.z;
    xy = xy + s.x * g.y;
    xz = xz + s.x * g.z;
    yz = yz + s.y * g.z;
  }
};

/// The Hessian of a vertex, factored (L D L^T).
template <class Scalar>
class VertexFactor {
 public:
  /// @param energy  whose isotropic part is positive
  PBDSURG_HOST_DEVICE explicit VertexFactor(const VertexEnergy<Scalar>& energy) {
    // No pivot is smaller than the smallest eigenvalue; neither may be what rounding leaves of one.
    const Scalar shift = energy.isotropic;
    const Scalar noise = Scalar(kRounding) * (energy.xx + energy.yy + energy.zz);
    const Scalar least = select(shift > noise, shift, noise);
    inverse_0_ = pivot(energy.xx + shift, least);
    row_10_ = energy.xy * inverse_0_;
    row_20_ = energy.xz * inverse_0_;
    inverse_1_ = pivot(energy.yy + shift - row_10_ * energy.xy, least);
    const Scalar rest = energy.yz - row_10_ * energy.xz;
    row_21_ = rest * inverse_1_;
    inverse_2_ = pivot(energy.zz + shift - row_20_ * energy.xz - row_21_ * rest, least);
  }

  /// @param b  N
  /// @return   m, by how much this force moves the vertex
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<Scalar> solve(const Vec3<Scalar>& b) const {
    const Scalar y = b.y - row_10_ * b.x;
    const Scalar z = (b.z - row_20_ * b.x - row_21_ * y) * inverse_2_;
    const Scalar y_moved = y * inverse_1_ - row_21_ * z;
    return {b.x * inverse_0_ - row_10_ * y_moved - row_20_ * z, y_moved, z};
  }

 private:
  static constexpr float kRounding = 1e-6F;  // a few units of single precision

  PBDSURG_HOST_DEVICE static Scalar pivot(Scalar value, Scalar least) {
    return Scalar(1) / select(value > least, value, least);
  }

  Scalar inverse_0_, inverse_1_, inverse_2_;  // m/N, of the pivots
  Scalar row_10_, row_20_, row_21_;
};

/// Hessian times a displacement, N.
template <class Scalar>
PBDSURG_HOST_DEVICE Vec3<Scalar> operator*(const VertexEnergy<Scalar>& energy,
                                           const Vec3<Scalar>& d) {
  return energy.isotropic * d + Vec3<Scalar>{energy.xx * d.x + energy.xy * d.y + energy.xz * d.z,
                                             energy.xy * d.x + energy.yy * d.y + energy.yz * d.z,
                                             energy.xz * d.x + energy.yz * d.y + energy.zz * d.z};
}

}  // namespace pbdsurg
