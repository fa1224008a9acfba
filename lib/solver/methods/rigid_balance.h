// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a piece of tissue moves as a rigid body that touches surfaces.
///
/// With the momentum P that sweeps have given it (momentum.h), M its mass and inertia, and f what a
/// contact answers to gap and slip (contact_answer.h), it is to move by the twist q with
///
///     P + M q = sum J^T f(q)
///
/// where J q is how the point of a contact goes. This is Newton's method with the contacts' springs
/// in the matrix, so a firm contact does not throw the piece, and with a step that is cut where
/// contacts begin to push or to slide (semismooth: Alart and Curnier 1991). In double precision.

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

PBDSURG_HOST_DEVICE inline double dot(const Screw& a, const Screw& b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}

PBDSURG_HOST_DEVICE inline Screw advanced(const Screw& from, double share, const Screw& way) {
  return {from.linear + share * way.linear, from.angular + share * way.angular};
}

/// A wrench for each twist: symmetric, positive definite.
class ScrewMatrix {
 public:
  /// Of a rigid body.
  PBDSURG_HOST_DEVICE ScrewMatrix(double mass, const Inertia& inertia)
      : rows_{{mass},
              {0, mass},
              {0, 0, mass},
              {0, 0, 0, inertia.xx},
              {0, 0, 0, inertia.xy, inertia.yy},
              {0, 0, 0, inertia.xz, inertia.yz, inertia.zz}} {}

  /// Adds a spring.
  /// @param stiffness  kg, along
  /// @param direction  of length 1, at
  /// @param arm        m
  PBDSURG_HOST_DEVICE void add(double stiffness, const Vec3<double>& direction,
                               const Vec3<double>& arm) {
    const Vec3<double> lever = cross(arm, direction);
    const double along[] = {direction.x, direction.y, direction.z, lever.x, lever.y, lever.z};
    for (int i = 0; i < kSize; ++i) {
      for (int j = 0; j <= i; ++j) {
        rows_[i][j] += stiffness * along[i] * along[j];
      }
    }
  }

  /// The twist of a wrench, by L L^T, which takes the place of the matrix.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw solve(const Screw& wrench) {
    double x[kSize] = {wrench.linear.x,  wrench.linear.y,  wrench.linear.z,
                       wrench.angular.x, wrench.angular.y, wrench.angular.z};
    for (int i = 0; i < kSize; ++i) {
      for (int j = 0; j < i; ++j) {
        for (int k = 0; k < j; ++k) {
          rows_[i][j] -= rows_[i][k] * rows_[j][k];
        }
        rows_[i][j] /= rows_[j][j];
        rows_[i][i] -= rows_[i][j] * rows_[i][j];
        x[i] -= rows_[i][j] * x[j];
      }
      rows_[i][i] = std::sqrt(rows_[i][i]);
      x[i] /= rows_[i][i];
    }
    for (int i = kSize - 1; i >= 0; --i) {
      for (int j = i + 1; j < kSize; ++j) {
        x[i] -= rows_[j][i] * x[j];
      }
      x[i] /= rows_[i][i];
    }
    return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  }

 private:
  static constexpr int kSize = 6;
  double rows_[kSize][kSize];  // lower triangle
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

/// Newton's method from no motion on, by a few rounds.
/// @tparam System  has imbalance(motion), what contacts give beyond the momentum of a motion, and
///                 way(motion, imbalance), Newton's step from it
/// @tparam Motion  has dot() and advanced(), as Screw has
template <class System, class Motion>
class BalancingMotion {
 public:
  PBDSURG_HOST_DEVICE explicit BalancingMotion(const System& system) : system_(system) {}

  [[nodiscard]] PBDSURG_HOST_DEVICE Motion from(Motion motion) const {
    double first_slope = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const Motion wrench = system_.imbalance(motion);
      const Motion way = system_.way(motion, wrench);
      const double slope = dot(wrench, way);
      first_slope = round == 0 ? slope : first_slope;
      if (!(slope > kLeastSlope * first_slope)) {
        break;
      }
      motion = advanced(motion, share_of(motion, way, slope), way);
    }
    return motion;
  }

 private:
  static constexpr int kMostRounds = 16;  // rarely more than six
  static constexpr int kMostCuts = 10;
  static constexpr double kLeastSlope = 1e-10;  // the square of what may stay out of balance
  static constexpr double kLevel = 0.25;        // of the slope, that counts as none along a way

  // Of a way, how much to go: all of it, unless that leads back; else to where it begins to, by
  // false position (Illinois: Dowell and Jarratt 1971).
  [[nodiscard]] PBDSURG_HOST_DEVICE double share_of(const Motion& from, const Motion& way,
                                                    double slope) const {
    double low = 0, low_slope = slope, high = 1, high_slope = 0, share = 1;
    int side = 0;  // of the share before
    for (int cut = 0; cut < kMostCuts; ++cut) {
      const double now = dot(system_.imbalance(advanced(from, share, way)), way);
      if (now > -kLevel * slope && (cut == 0 || now < kLevel * slope)) {
        break;
      }
      if (now < 0) {
        high = share;
        high_slope = now;
        low_slope *= side < 0 ? 0.5 : 1;
        side = -1;
      } else {
        low = share;
        low_slope = now;
        high_slope *= side > 0 ? 0.5 : 1;
        side = 1;
      }
      share = low + (high - low) * low_slope / (low_slope - high_slope);
    }
    return share;
  }

  const System& system_;
};

/// Of one piece.
class RigidBalance {
 public:
  /// @param sums      of a piece with mass
  /// @param contacts  [count] that live as long as this
  PBDSURG_HOST_DEVICE RigidBalance(const MomentumSums& sums, const RigidContact* contacts,
                                   Index count)
      : body_(sums), contacts_(contacts), count_(count) {}

  /// The twist q.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw twist() const {
    return BalancingMotion<RigidBalance, Screw>(*this).from({});
  }

  // For BalancingMotion.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw imbalance(const Screw& twist) const {
    Screw sum = body_.lack(twist);
    for (Index c = 0; c < count_; ++c) {
      const ContactForce<double> force = contacts_[c].answer(move_of(contacts_[c], twist)).force;
      const Vec3<double> push = force.push * contacts_[c].normal + force.drag;
      sum.linear = sum.linear + push;
      sum.angular = sum.angular + cross(contacts_[c].arm, push);
    }
    return sum;
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw way(const Screw& twist, const Screw& wrench) const {
    ScrewMatrix sum(body_.mass, body_.inertia);
    for (Index c = 0; c < count_; ++c) {
      const RigidContact& contact = contacts_[c];
      contact.for_each_spring(contact.answer(move_of(contact, twist)),
                              [&](double stiffness, const Vec3<double>& direction) {
                                sum.add(stiffness, direction, contact.arm);
                              });
    }
    return sum.solve(wrench);
  }

 private:
  // How a contact moves by a twist.
  PBDSURG_HOST_DEVICE static Vec3<double> move_of(const RigidContact& contact, const Screw& twist) {
    return twist.linear + cross(twist.angular, contact.arm);
  }

  RigidBody body_;
  const RigidContact* contacts_;
  Index count_;
};

}  // namespace pbdsurg
