// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a free piece of tissue that contacts push eases off, of BDF2: as eased() has it of a vertex
/// along a normal, of the piece along the rigid motion that the pushes are. On a CPU or a device;
/// summed in the order of momentum.h.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/momentum.h"

namespace pbdsurg {

/// What is to change of velocities, 1/s, times a rigid motion.
struct Easing {
  double now;     ///< <= 0
  double before;  ///< >= 0
};

/// What the contacts of a piece have pushed it by.
struct Pushes {
  MomentumSums sums;  ///< about the origin
  double total = 0;   ///< kg m, without directions

  /// @param push    kg m, along
  /// @param normal  unit, at
  /// @param arm     m
  PBDSURG_HOST_DEVICE void add(float push, const Vec3<float>& normal, const Vec3<double>& arm) {
    const Vec3<double> along = to_double(push * normal);
    total = total + push;
    sums.gain = sums.gain + along;
    sums.moment = sums.moment + cross(arm, along);
  }
};

/// Of two pieces that push each other, of which each has what it gets: what both have in common of
/// mass stands for that of one.
[[nodiscard]] PBDSURG_HOST_DEVICE inline Pushes between(const Pushes& one, const Pushes& other) {
  Pushes pushes;
  pushes.total = one.total;
  pushes.sums.mass = 1 / (1 / one.sums.mass + 1 / other.sums.mass);
  return pushes;
}

/// How a piece goes along its pushes.
struct EasingSums {
  double square = 0;        ///< kg m^2, of the motion
  double speed = 0;         ///< kg m^2/s, of velocities now
  double mean = 0;          ///< likewise, of the substep's way
  double speed_before = 0;  ///< likewise, of velocities before

  /// @param m       kg
  /// @param along   m, of the rigid motion
  /// @param h       s
  PBDSURG_HOST_DEVICE void add(double m, const Vec3<double>& along, const Vec3<float>& velocity,
                               const Vec3<float>& way, const Vec3<float>& velocity_before,
                               double h) {
    square = square + m * dot(along, along);
    speed = speed + m * dot(along, to_double(velocity));
    mean = mean + m * dot(along, to_double(way)) / h;
    speed_before = speed_before + m * dot(along, to_double(velocity_before));
  }

  PBDSURG_HOST_DEVICE void add(const EasingSums& other) {
    square = square + other.square;
    speed = speed + other.speed;
    mean = mean + other.mean;
    speed_before = speed_before + other.speed_before;
  }

  /// Less where pushes cancel each other, as those of jaws do.
  [[nodiscard]] PBDSURG_HOST_DEVICE Easing easing(const Pushes& pushes) const {
    if (!(square > 0)) {
      return {0, 0};
    }
    const double most = square * pushes.sums.mass / (pushes.total * pushes.total);
    const double share = most < 1 ? most : 1;
    const double less = speed > mean ? speed - mean : 0;
    const double rest = speed - less - speed_before;
    return {-share * less / square, share * (rest > 0 ? rest : 0) / square};
  }
};

/// 1/s^2, of a push: what the tool does not feel of it, since later substeps take it back.
/// @param h         s, of the substep
/// @param per_step  share of the step that counts for it
/// @param density   factor of the copy
PBDSURG_HOST_DEVICE inline float relief_of(const Easing& easing, float h, double per_step,
                                           float density) {
  const double rate = (1.5 * easing.now - 0.5 * easing.before) / (h * per_step);
  return static_cast<float>(rate * density);
}

}  // namespace pbdsurg
