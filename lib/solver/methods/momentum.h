// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps the momentum of a free piece through the sweeps of a substep.
///
/// The forces within a piece sum to zero and have no moment, so they change neither
///
///     P = sum m (u - y)      nor      L = sum m r x (u - y),
///
/// with u where sweeps have left the displacements, y where the vertices fly by themselves and r
/// from where the substep starts: then sum (r + u) x m u is sum r x m u, and angular momentum stays
/// as it is, whatever the length of the substep. BDF2 keeps it by itself where r is taken to where
/// the substep ends: from its start it would gain spin. Sweeps that end early leave some of both.
/// The rigid motion t + omega x (r - c) with that much is taken off the displacements, which
/// changes no shape to first order. In double precision, summed in one order by all who step.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// Vertex i of a piece goes to sum i modulo this; then, half by half, sum i takes sum i + half.
inline constexpr Index kMomentumSums = 256;

/// A rigid motion, to first order.
struct RigidMove {
  Vec3<double> shift;   ///< m, of the centre
  Vec3<double> turn;    ///< rad
  Vec3<double> centre;  ///< m, of mass
};

/// How masses lie around their centre.
struct Inertia {
  double xx, yy, zz, xy, xz, yz;  ///< kg m^2, a little more than nothing around a line
  bool is_spread;  ///< else it is of a single vertex, or of several at one place, and does not turn
};

/// What some vertices have gained against their flights, and how their masses lie.
struct MomentumSums {
  double mass = 0;                                        ///< kg
  Vec3<double> first;                                     ///< kg m, sum m r
  Vec3<double> gain;                                      ///< kg m, sum m d
  Vec3<double> moment;                                    ///< kg m^2, sum m r x d
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;  ///< kg m^2, sum m r r^T

  /// @param m  kg
  /// @param r  m, see arm_of()
  /// @param d  m, the displacement beyond the flight
  PBDSURG_HOST_DEVICE void add(double m, const Vec3<double>& r, const Vec3<double>& d) {
    mass = mass + m;
    first = first + m * r;
    gain = gain + m * d;
    moment = moment + m * cross(r, d);
    xx = xx + m * (r.x * r.x);
    yy = yy + m * (r.y * r.y);
    zz = zz + m * (r.z * r.z);
    xy = xy + m * (r.x * r.y);
    xz = xz + m * (r.x * r.z);
    yz = yz + m * (r.y * r.z);
  }

  PBDSURG_HOST_DEVICE void add(const MomentumSums& other) {
    mass = mass + other.mass;
    first = first + other.first;
    gain = gain + other.gain;
    moment = moment + other.moment;
    xx = xx + other.xx;
    yy = yy + other.yy;
    zz = zz + other.zz;
    xy = xy + other.xy;
    xz = xz + other.xz;
    yz = yz + other.yz;
  }

  /// m, of mass.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<double> centre() const { return (1 / mass) * first; }

  [[nodiscard]] PBDSURG_HOST_DEVICE Inertia inertia() const {
    const Vec3<double> c = centre();
    // second moments about the centre
    const double sxx = xx - c.x * first.x, syy = yy - c.y * first.y, szz = zz - c.z * first.z;
    const double spread = sxx + syy + szz;
    const double floor = kLeastInertia * spread;
    return {syy + szz + floor,
            sxx + szz + floor,
            sxx + syy + floor,
            -(xy - c.x * first.y),
            -(xz - c.x * first.z),
            -(yz - c.y * first.z),
            spread > kLeastSpread * (xx + yy + zz)};
  }

  /// kg m^2, about the centre.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<double> moment_about_centre() const {
    return moment - cross(centre(), gain);
  }

  /// The rigid motion that has gain and moment. What lies on a line does not turn around it.
  [[nodiscard]] PBDSURG_HOST_DEVICE RigidMove rigid_move() const {
    RigidMove move{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    if (!(mass > 0)) {
      return move;
    }
    move.centre = centre();
    move.shift = (1 / mass) * gain;
    const Inertia i = inertia();
    if (!i.is_spread) {
      return move;
    }
    const Vec3<double> b = moment_about_centre();
    // L D L^T
    const double l10 = i.xy / i.xx;
    const double l20 = i.xz / i.xx;
    const double d1 = i.yy - l10 * i.xy;
    const double rest = i.yz - l10 * i.xz;
    const double l21 = rest / d1;
    const double d2 = i.zz - l20 * i.xz - l21 * rest;
    const double y = b.y - l10 * b.x;
    const double z = (b.z - l20 * b.x - l21 * y) / d2;
    move.turn.z = z;
    move.turn.y = y / d1 - l21 * z;
    move.turn.x = b.x / i.xx - l10 * move.turn.y - l20 * z;
    return move;
  }

 private:
  // of the sums that differences are of; far above what doubles round, far below any tissue
  static constexpr double kLeastSpread = 1e-12;
  static constexpr double kLeastInertia = 1e-9;  // of the spread: what a line has around itself
};

/// m, what a vertex has of a rigid motion.
/// @param r  m, as above
PBDSURG_HOST_DEVICE inline Vec3<float> part_of(const RigidMove& move, const Vec3<double>& r) {
  const Vec3<double> d = move.shift + cross(move.turn, r - move.centre);
  return {static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)};
}

PBDSURG_HOST_DEVICE inline Vec3<double> to_double(const Vec3<float>& v) {
  return {v.x, v.y, v.z};
}

/// m, r of a vertex.
/// @param u            m, its displacement
/// @param is_from_end  of the substep, as BDF2 wants it
PBDSURG_HOST_DEVICE inline Vec3<double> arm_of(const Vec3<float>& base, const Vec3<float>& u,
                                               bool is_from_end) {
  return is_from_end ? to_double(base) + to_double(u) : to_double(base);
}

/// Whether a vertex counts: it moves, and it is not lost. Beyond a kilometre, what floats round
/// would be taken for momentum.
/// @param u       m, its displacement
/// @param flight  m
PBDSURG_HOST_DEVICE inline bool keeps_momentum(float w, const Vec3<float>& base,
                                               const Vec3<float>& u, const Vec3<float>& flight) {
  constexpr float kFarthest = 1e3F * 1e3F;
  return w > 0 && dot(base, base) < kFarthest && dot(u, u) < kFarthest &&
         dot(flight, flight) < kFarthest;
}

}  // namespace pbdsurg
