// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How vertices move through a substep: on a CPU, a register of them, or a device.
///
/// In compliance mode the unknown of a substep is the displacement u from where a vertex was at its
/// start, and the position x stays until its end:
///
///     start     v' = keep v + kick,  u = c + h v'        c: what x lacks by rounding
///     sweeps    change u; corners are seen as (x_k - x_0) + (u_k - u_0)
///     end       x'' = x + u, rounded;  c = u - (x'' - x);  v = v' + (u - (c + h v')) / h
///
/// So no velocity is the difference of positions that were rounded, where no tool holds a vertex: a
/// substep of microseconds far from the origin moves vertices by less than the spacing of numbers
/// there. In fraction mode positions move themselves, as in the paper, and round.
///
/// BDF2 asks, with the velocity v- and the displacement u- of the substep before, r the ratio of
/// this substep's length to that one's, a = r^2 / (1 + 2 r) and b = (1 + r) / (1 + 2 r), for
///
///     v'' = v + a (v - v-) + b h forces / m,    u = a u- + b h v''
///
/// which is the implicit Euler substep above of length b h, once v + a (v - v-) takes the place of
/// v and c + a u- that of c. So all between start and end is the same for both, and takes b h for
/// its h. A ratio of zero makes it implicit Euler, which needs nothing from before.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// What a substep does to a vertex that nothing holds.
template <class Scalar>
struct FreeMotion {
  Scalar h;                         ///< s
  Scalar inverse_h;                 ///< 1/s
  Scalar keep;                      ///< share of the velocity that drag leaves
  Vec3<Scalar> kick;                ///< m/s, of gravity
  Vec3<Scalar> fall;                ///< m, what gravity adds to the way
  Vec3<Scalar> gravity_per_square;  ///< s^2/m, gravity over its square; zero without gravity
  // of any acceleration, as of gravity
  Scalar kick_time;    ///< s, the kick over it
  Scalar fall_square;  ///< s^2, the fall over it
  // where a copy has factors, which gravity above follows
  Scalar inverse_gravity;  ///< one over that of gravity; zero of no gravity
  Scalar push_time;        ///< s, the kick of a force over force and inverse mass
};

/// Of a vertex with a gravity of its own.
/// @param gravity         m/s^2
/// @param inverse_square  s^4/m^2, of it; zero without gravity
template <class Scalar>
PBDSURG_HOST_DEVICE inline FreeMotion<Scalar> under(const Vec3<Scalar>& gravity,
                                                    Scalar inverse_square,
                                                    FreeMotion<Scalar> motion) {
  motion.kick = motion.kick_time * gravity;
  motion.fall = motion.fall_square * gravity;
  motion.gravity_per_square = (motion.inverse_gravity * inverse_square) * gravity;
  return motion;
}

/// Of a vertex that a force from outside pushes. It is part of the flight, so that sweeps end where
/// all forces balance, but not of start_of(): a force on few light vertices would throw these far
/// out of what they belong to. Nor of settle(), whose velocity does not depend on the kick.
/// @param force  N
/// @param w      1/kg
template <class Scalar>
PBDSURG_HOST_DEVICE inline FreeMotion<Scalar> pushed_by(const Vec3<Scalar>& force, Scalar w,
                                                        FreeMotion<Scalar> motion) {
  motion.kick = motion.kick + (motion.push_time * w) * force;
  return motion;
}

/// Velocity and rounding of a vertex before a substep, in m/s and m.
template <class Scalar>
struct Departure {
  Vec3<Scalar> velocity, rounding;
};

/// What BDF2 begins with in place of both.
/// @param share            a of BDF2, see above
/// @param way              m, in the substep before
/// @param velocity_before  m/s, where that began
template <class Scalar>
PBDSURG_HOST_DEVICE inline Departure<Scalar> departure_after(const Departure<Scalar>& now, Scalar w,
                                                             Scalar share, const Vec3<Scalar>& way,
                                                             const Vec3<Scalar>& velocity_before) {
  return {
      select(w > Scalar(0), now.velocity + share * (now.velocity - velocity_before), now.velocity),
      select(w > Scalar(0), now.rounding + share * way, now.rounding)};
}

/// What BDF2 remembers of a substep, changed for a vertex that a tool pushed in it.
template <class Scalar>
struct Pushed {
  Vec3<Scalar> velocity, velocity_before;  ///< m/s
};

/// Backward differences of second order take the stop of a motion for the beginning of its return:
/// what fell onto a tool would spring back faster than it fell. So along the normal a pushed vertex
/// is no faster away from the tool than on its way, and has not become so.
/// @param normal  out of the tool
/// @param way     m, of the vertex in the substep
template <class Scalar>
PBDSURG_HOST_DEVICE inline Pushed<Scalar> eased(const Pushed<Scalar>& now,
                                                const Vec3<Scalar>& normal, const Vec3<Scalar>& way,
                                                Scalar inverse_h) {
  const Scalar speed = dot(normal, now.velocity);
  const Scalar mean = inverse_h * dot(normal, way);
  const Scalar less = select(mean < speed, mean - speed, Scalar(0));
  const Scalar gain = speed + less - dot(normal, now.velocity_before);
  return {now.velocity + less * normal,
          now.velocity_before + select(gain > Scalar(0), gain, Scalar(0)) * normal};
}

/// m/s, with which a vertex begins a substep; zero where it cannot move.
template <class Scalar>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> flying_velocity(const FreeMotion<Scalar>& motion,
                                                        const Vec3<Scalar>& velocity, Scalar w) {
  return select(w > Scalar(0), motion.keep * velocity + motion.kick, Vec3<Scalar>{});
}

/// m, the displacement of a vertex that nothing holds.
/// @param rounding  m, of its position, see Carry
/// @param velocity  m/s, flying_velocity()
template <class Scalar>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> flight_of(const FreeMotion<Scalar>& motion,
                                                  const Vec3<Scalar>& rounding,
                                                  const Vec3<Scalar>& velocity) {
  return rounding + motion.h * velocity;
}

/// m, what a force adds to the displacement of a vertex that nothing else holds.
/// @param force  N
/// @param w      1/kg
template <class Scalar>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> pushed_flight(const Vec3<Scalar>& force, Scalar w,
                                                      Scalar inverse_dt_squared) {
  return (w / inverse_dt_squared) * force;
}

/// m, the displacement from which sweeps of vertex blocks begin: as if the vertex fell as before.
/// What rests would else fall first, and sweeps that are too few would not bring it back.
/// @param flight   m, of the vertex
/// @param falling  see Carry
template <class Scalar>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> start_of(const FreeMotion<Scalar>& motion,
                                                 const Vec3<Scalar>& flight, Scalar w,
                                                 Scalar falling) {
  return flight - select(w > Scalar(0), Scalar(1) - falling, Scalar(0)) * motion.fall;
}

/// A vertex after a substep.
template <class Scalar>
struct Settled {
  Vec3<Scalar> x;         ///< m
  Vec3<Scalar> velocity;  ///< m/s
  Vec3<Scalar> rounding;  ///< m
  Scalar falling;
};

/// @param x         m, where the vertex was, with
/// @param velocity  m/s, and
/// @param rounding  m
/// @param u         m, its displacement
template <class Scalar>
PBDSURG_HOST_DEVICE inline Settled<Scalar> settle(const FreeMotion<Scalar>& motion,
                                                  const Vec3<Scalar>& x, Scalar w,
                                                  const Vec3<Scalar>& velocity,
                                                  const Vec3<Scalar>& rounding,
                                                  const Vec3<Scalar>& u) {
  const Vec3<Scalar> flying = flying_velocity(motion, velocity, w);
  Settled<Scalar> end;
  end.velocity = flying + motion.inverse_h * (u - flight_of(motion, rounding, flying));
  end.x = x + u;
  end.rounding = u - (end.x - x);
  const Scalar share = motion.inverse_h * dot(end.velocity - velocity, motion.gravity_per_square);
  // in this order, of what is no number it makes zero
  end.falling = select(share > Scalar(0), select(share < Scalar(1), share, Scalar(1)), Scalar(0));
  return end;
}

/// Where a corner of a constraint is, as that sees it: from the first.
/// @param bases  m, where corners were at the start of the substep
/// @param u      m, their displacements
template <int kCorner, class Scalar, int kVertexCount>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> seen_corner(const Vec3<Scalar> (&bases)[kVertexCount],
                                                    const Vec3<Scalar> (&u)[kVertexCount]) {
  if constexpr (kCorner == 0) {
    return {};
  } else {
    return (bases[kCorner] - bases[0]) + (u[kCorner] - u[0]);
  }
}

/// All of them.
template <class Scalar, int kVertexCount>
PBDSURG_HOST_DEVICE inline void see_corners(const Vec3<Scalar> (&bases)[kVertexCount],
                                            const Vec3<Scalar> (&u)[kVertexCount],
                                            Vec3<Scalar> (&seen)[kVertexCount]) {
  static_assert(kVertexCount >= 2 && kVertexCount <= 4);
  seen[0] = seen_corner<0>(bases, u);
  seen[1] = seen_corner<1>(bases, u);
  if constexpr (kVertexCount > 2) {
    seen[2] = seen_corner<2>(bases, u);
  }
  if constexpr (kVertexCount > 3) {
    seen[3] = seen_corner<3>(bases, u);
  }
}

}  // namespace pbdsurg
