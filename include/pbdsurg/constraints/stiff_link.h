// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Joins two vertices of the vertex-block method by a link that is much stiffer than their tissue,
/// down to compliance 0. As a spring in the energy of each end it would keep both where they are:
/// each end is held by the last place of the other. So both ends move together here, by the force
/// with which the link is satisfied once they have given way to it:
///
///     x0 o->- - - -<-o x1      d = x1 - x0                                     m
///         f         -f         |d| = rest length + compliance |f|, along f     m
///                              G: how far both ends give way to a force        m/N
///
/// With the link's force of before, f', the ends are at d; without any, at d' = d + G f'. Then
///
///     rest length 0:     f = (compliance I + G)^-1 d'
///     rest length > 0:   f = (n d' - rest length) / (compliance + n G n) n
///                        n along (I + s G)^-1 d', s = |f'| / |d| where it pulls: the ends turn,
///                        too
///
/// which is the Schur complement of the two vertices' blocks. Between these moves f acts on both
/// vertices as a load. After Macklin et al. 2016, "XPBD", with the inverse of the Hessian of a
/// vertex (constraints/vertex_block.h) in place of its inverse mass. The force of a link with a
/// length whose ends meet stays what it was until they part.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"

namespace pbdsurg {

/// How far a vertex gives way to a force, m/N: a symmetric matrix, positive semidefinite.
template <class Scalar>
struct VertexGive {
  Scalar xx{},  ///< m/N
      yy{},     ///< m/N
      zz{},     ///< m/N
      xy{},     ///< m/N
      xz{},     ///< m/N
      yz{};     ///< m/N

  /// Of a vertex with this Hessian: its inverse.
  PBDSURG_HOST_DEVICE static VertexGive of(const VertexFactor<Scalar>& factor) {
    const Vec3<Scalar> x = factor.solve({Scalar(1), Scalar(0), Scalar(0)});
    const Vec3<Scalar> y = factor.solve({Scalar(0), Scalar(1), Scalar(0)});
    const Vec3<Scalar> z = factor.solve({Scalar(0), Scalar(0), Scalar(1)});
    return {x.x, y.y, z.z, x.y, x.z, y.z};
  }

  /// Of two vertices that a force pulls at, each its own way: how far it brings them together.
  PBDSURG_HOST_DEVICE friend VertexGive operator+(const VertexGive& a, const VertexGive& b) {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
  }

  /// m, under a force in N.
  PBDSURG_HOST_DEVICE friend Vec3<Scalar> operator*(const VertexGive& give, const Vec3<Scalar>& f) {
    return {give.xx * f.x + give.xy * f.y + give.xz * f.z,
            give.xy * f.x + give.yy * f.y + give.yz * f.z,
            give.xz * f.x + give.yz * f.y + give.zz * f.z};
  }
};

/// Joins two vertices of the vertex-block method: constraints/stiff_link.h has the equations.
struct StiffLinkConstraint {
  static constexpr int kVertexCount = 2;       ///< vertices of one constraint
  static constexpr int kMultiplierCount = 15;  ///< of a Joint
  /// What one constraint stores.
  enum Parameter {
    kRest,           ///< m
    kStiffness,      ///< compliance in m/N
    kShare,          ///< of the way to the force that satisfies it, in one projection
    kParameterCount  ///< how many these are
  };

  /// What it keeps over a substep.
  template <class Scalar>
  struct Joint {
    Vec3<Scalar> force;          ///< N, on the first vertex; the other has the opposite
    VertexGive<Scalar> give[2];  ///< of each vertex, without the link

    /// Out of the multipliers of a constraint.
    PBDSURG_HOST_DEVICE void load(const Scalar (&from)[kMultiplierCount]) {
      force = {from[0], from[1], from[2]};
      give[0] = {from[3], from[4], from[5], from[6], from[7], from[8]};
      give[1] = {from[9], from[10], from[11], from[12], from[13], from[14]};
    }
    /// Into them.
    PBDSURG_HOST_DEVICE void store(Scalar (&to)[kMultiplierCount]) const {
      to[0] = force.x, to[1] = force.y, to[2] = force.z;
      for (int k = 0; k < 2; ++k) {
        Scalar* const first = to + 3 + 6 * k;
        first[0] = give[k].xx, first[1] = give[k].yy, first[2] = give[k].zz;
        first[3] = give[k].xy, first[4] = give[k].xz, first[5] = give[k].yz;
      }
    }
  };

  /// The force of a Joint.
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Vec3<Scalar> force_of(const Scalar (&multipliers)[kMultiplierCount]) {
    return {multipliers[0], multipliers[1], multipliers[2]};
  }

  /// The force that satisfies the link, N, on the first vertex; as before where that is no number,
  /// or no end gives way.
  /// @param d           m, from the first vertex to the other, under the force of the joint
  /// @param rest        m, >= 0
  /// @param compliance  m/N, >= 0
  template <class Scalar>
  PBDSURG_HOST_DEVICE static Vec3<Scalar> force(const Joint<Scalar>& joint, const Vec3<Scalar>& d,
                                                Scalar rest, Scalar compliance) {
    using std::sqrt;
    const VertexGive<Scalar> give = joint.give[0] + joint.give[1];
    const Vec3<Scalar> free = d + give * joint.force;  // from vertex to vertex without the link

    const Scalar square = dot(d, d);
    const Scalar pull_per_length = dot(joint.force, d) / square;  // of a taut link, else < 0
    const auto is_taut = (pull_per_length > Scalar(0)) & is_usable(square);
    const Scalar turning = select(is_taut, pull_per_length, Scalar(0));
    VertexEnergy<Scalar> turned;
    turned.isotropic = Scalar(1);
    turned.xx = turning * give.xx, turned.yy = turning * give.yy, turned.zz = turning * give.zz;
    turned.xy = turning * give.xy, turned.xz = turning * give.xz, turned.yz = turning * give.yz;
    const Vec3<Scalar> way = select(is_taut, VertexFactor<Scalar>(turned).solve(free), d);
    const Scalar length = sqrt(dot(way, way));
    const auto has_direction = is_usable(length);
    const Vec3<Scalar> n = select(has_direction, (Scalar(1) / length) * way, Vec3<Scalar>{});
    const Scalar mobility = compliance + dot(n, give * n);
    const Scalar tension = (dot(n, free) - rest) / mobility;
    const auto holds_length = has_direction & is_usable(mobility);

    VertexEnergy<Scalar> both;
    both.isotropic = compliance;
    both.xx = give.xx, both.yy = give.yy, both.zz = give.zz;
    both.xy = give.xy, both.xz = give.xz, both.yz = give.yz;
    const auto gives = is_usable(compliance + give.xx + give.yy + give.zz);
    const Vec3<Scalar> pull = VertexFactor<Scalar>(both).solve(free);

    const Vec3<Scalar> found =
        select(rest > Scalar(0), select(holds_length, tension * n, joint.force),
               select(gives, pull, joint.force));
    return select(dot(found, found) < Scalar(kInfinity), found, joint.force);
  }

  /// One projection: a share of the way to that force.
  ///
  /// @param x            m
  /// @param multipliers  a Joint, whose force changes
  /// @return             m
  template <ProjectionMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 2> move(const Vec3<Scalar> (&x)[2], const Scalar (&)[2],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>&,
                                                   Scalar (&multipliers)[kMultiplierCount],
                                                   const Damping& = {}) {
    Joint<Scalar> joint;
    joint.load(multipliers);
    const Vec3<Scalar> before = joint.force;
    const Vec3<Scalar> found = force(joint, x[1] - x[0], parameters[kRest], parameters[kStiffness]);
    const Vec3<Scalar> change = parameters[kShare] * (found - before);
    joint.force = before + change;
    joint.store(multipliers);
    return {{joint.give[0] * change, Scalar(-1) * (joint.give[1] * change)}};
  }
};

}  // namespace pbdsurg
