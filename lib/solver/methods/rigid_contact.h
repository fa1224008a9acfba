// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A piece of tissue that moves as a rigid body, and what it touches, on a CPU or a device: see
/// group_balance.h.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/contact_answer.h"
#include "lib/solver/methods/momentum.h"

namespace pbdsurg {

/// A twist in m and rad, or a wrench in kg m and kg m^2, about a centre of mass.
struct Screw {
  Vec3<double> linear{0, 0, 0}, angular{0, 0, 0};
};

/// A contact of a piece, in the unit of its multipliers.
struct RigidContact {
  Vec3<double> arm;  ///< m, from the centre of mass
  Vec3<double> normal;
  ContactReading<double> reading;
  ContactForce<double> force;  ///< kg m, before
  double friction;             ///< coefficient
  double stiffness;            ///< kg

  /// What it answers once its point has moved.
  [[nodiscard]] PBDSURG_HOST_DEVICE ContactAnswer<double> answer(const Vec3<double>& move) const {
    const double rise = dot(normal, move);
    return contact_answer(force, friction,
                          {reading.gap + rise, reading.slip + (move - rise * normal)}, stiffness);
  }

  /// Calls add(stiffness, direction) for the springs of an answer. What slides yields along its
  /// drag.
  template <class Add>
  PBDSURG_HOST_DEVICE void for_each_spring(const ContactAnswer<double>& answer,
                                           const Add& add) const {
    const auto& [now, sticking] = answer;
    if (!(now.push > 0)) {
      return;
    }
    add(stiffness, normal);
    if (!(friction > 0)) {
      return;
    }
    const bool slides = sticking < 1;
    const Vec3<double> along = slides ? normalized(now.drag) : any_across(normal);
    add(sticking * stiffness, cross(normal, along));
    if (!slides) {
      add(stiffness, along);
    }
  }

 private:
  PBDSURG_HOST_DEVICE static Vec3<double> normalized(const Vec3<double>& v) {
    return (1 / std::sqrt(dot(v, v))) * v;
  }

  PBDSURG_HOST_DEVICE static Vec3<double> any_across(const Vec3<double>& n) {
    constexpr double kNotAlong = 0.6;  // one over the square root of three, and some
    return normalized(std::fabs(n.x) < kNotAlong ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0}));
  }
};

/// A piece with mass, and what sweeps have given it.
struct RigidBody {
  PBDSURG_HOST_DEVICE explicit RigidBody(const MomentumSums& sums)
      : mass(sums.mass), inertia(sums.inertia()), momentum{sums.gain, sums.moment_about_centre()} {
    if (!inertia.is_spread) {  // turns no further than a kilogram that is a meter away
      inertia = {1, 1, 1, 0, 0, 0, false};
      momentum.angular = {0, 0, 0};
    }
  }

  /// -(P + M q), what it lacks of momentum at a twist.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw lack(const Screw& twist) const {
    const Vec3<double>& w = twist.angular;
    const Inertia& i = inertia;
    const Vec3<double> spin{i.xx * w.x + i.xy * w.y + i.xz * w.z,
                            i.xy * w.x + i.yy * w.y + i.yz * w.z,
                            i.xz * w.x + i.yz * w.y + i.zz * w.z};
    return {-1.0 * momentum.linear - mass * twist.linear, -1.0 * momentum.angular - spin};
  }

  double mass;
  Inertia inertia;
  Screw momentum;
};

}  // namespace pbdsurg
