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
};

class RigidBalance {
 public:
  /// @param sums      of a piece with mass
  /// @param contacts  [count] that live as long as this
  PBDSURG_HOST_DEVICE RigidBalance(const MomentumSums& sums, const RigidContact* contacts,
                                   Index count)
      : mass_(sums.mass),
        inertia_(sums.inertia()),
        momentum_{sums.gain, sums.moment_about_centre()},
        contacts_(contacts),
        count_(count) {
    if (!inertia_.is_spread) {  // turns no further than a kilogram that is a meter away
      inertia_ = {1, 1, 1, 0, 0, 0, false};
      momentum_.angular = {0, 0, 0};
    }
  }

  /// The twist q, from the one before closer to it by each of a few rounds.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw twist() const {
    Screw twist;
    double first_slope = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const Screw wrench = imbalance(twist);
      const Screw way = stiffness(twist).solve(wrench);
      const double slope = dot(wrench, way);
      first_slope = round == 0 ? slope : first_slope;
      if (!(slope > kLeastSlope * first_slope)) {
        break;
      }
      twist = advanced(twist, share_of(twist, way, slope), way);
    }
    return twist;
  }

 private:
  static constexpr int kMostRounds = 16;  // rarely more than six
  static constexpr int kMostCuts = 10;
  static constexpr double kLeastSlope = 1e-10;  // the square of what may stay out of balance
  static constexpr double kLevel = 0.25;        // of the slope, that counts as none along a way

  // How a contact moves by a twist.
  PBDSURG_HOST_DEVICE static Vec3<double> move_of(const RigidContact& contact, const Screw& twist) {
    return twist.linear + cross(twist.angular, contact.arm);
  }

  PBDSURG_HOST_DEVICE static ContactAnswer<double> answer(const RigidContact& contact,
                                                          const Screw& twist) {
    const Vec3<double> move = move_of(contact, twist);
    const double rise = dot(contact.normal, move);
    return contact_answer(
        contact.force, contact.friction,
        {contact.reading.gap + rise, contact.reading.slip + (move - rise * contact.normal)},
        contact.stiffness);
  }

  // What contacts give beyond the momentum of a twist.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw imbalance(const Screw& twist) const {
    const Vec3<double>& w = twist.angular;
    const Inertia& i = inertia_;
    const Vec3<double> spin{i.xx * w.x + i.xy * w.y + i.xz * w.z,
                            i.xy * w.x + i.yy * w.y + i.yz * w.z,
                            i.xz * w.x + i.yz * w.y + i.zz * w.z};
    Screw sum{-1.0 * momentum_.linear - mass_ * twist.linear, -1.0 * momentum_.angular - spin};
    for (Index c = 0; c < count_; ++c) {
      const ContactForce<double> force = answer(contacts_[c], twist).force;
      const Vec3<double> push = force.push * contacts_[c].normal + force.drag;
      sum.linear = sum.linear + push;
      sum.angular = sum.angular + cross(contacts_[c].arm, push);
    }
    return sum;
  }

  // How the imbalance shrinks. A contact that slides yields along its drag.
  [[nodiscard]] PBDSURG_HOST_DEVICE ScrewMatrix stiffness(const Screw& twist) const {
    ScrewMatrix sum(mass_, inertia_);
    for (Index c = 0; c < count_; ++c) {
      const RigidContact& contact = contacts_[c];
      const Vec3<double>& n = contact.normal;
      const auto [force, sticking] = answer(contact, twist);
      if (!(force.push > 0)) {
        continue;
      }
      sum.add(contact.stiffness, n, contact.arm);
      if (!(contact.friction > 0)) {
        continue;
      }
      const bool slides = sticking < 1;
      const Vec3<double> along = slides ? normalized(force.drag) : any_across(n);
      sum.add(sticking * contact.stiffness, cross(n, along), contact.arm);
      if (!slides) {
        sum.add(contact.stiffness, along, contact.arm);
      }
    }
    return sum;
  }

  // Of a way, how much to go: all of it, unless that leads back; else to where it begins to, by
  // false position (Illinois: Dowell and Jarratt 1971).
  [[nodiscard]] PBDSURG_HOST_DEVICE double share_of(const Screw& from, const Screw& way,
                                                    double slope) const {
    double low = 0, low_slope = slope, high = 1, high_slope = 0, share = 1;
    int side = 0;  // of the share before
    for (int cut = 0; cut < kMostCuts; ++cut) {
      const double now = dot(imbalance(advanced(from, share, way)), way);
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

  PBDSURG_HOST_DEVICE static Vec3<double> normalized(const Vec3<double>& v) {
    return (1 / std::sqrt(dot(v, v))) * v;
  }

  PBDSURG_HOST_DEVICE static Vec3<double> any_across(const Vec3<double>& n) {
    constexpr double kNotAlong = 0.6;  // one over the square root of three, and some
    return normalized(std::fabs(n.x) < kNotAlong ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0}));
  }

  double mass_;
  Inertia inertia_;
  Screw momentum_;
  const RigidContact* contacts_;
  Index count_;
};

}  // namespace pbdsurg
