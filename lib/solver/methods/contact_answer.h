// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The force of a contact with a surface, by its multipliers: see surface_contacts.h.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// Gap and slip of a contact now.
template <class Scalar>
struct ContactReading {
  Scalar gap;         ///< m
  Vec3<Scalar> slip;  ///< m, along the tool's surface
};

/// Multipliers of a contact, in kg m or scaled.
template <class Scalar>
struct ContactForce {
  Scalar push;        ///< along the normal, >= 0
  Vec3<Scalar> drag;  ///< along the tool's surface
};

/// What they become after a gap and a slip.
template <class Scalar>
struct ContactAnswer {
  ContactForce<Scalar> force;
  Scalar sticking;  ///< share of the drag that friction bears, at most 1
};

/// @param before     the multipliers
/// @param friction   coefficient
/// @param stiffness  in their unit, a meter
template <class Scalar>
PBDSURG_HOST_DEVICE inline ContactAnswer<Scalar> contact_answer(
    const ContactForce<Scalar>& before, Scalar friction, const ContactReading<Scalar>& reading,
    Scalar stiffness) {
  using std::sqrt;
  const Scalar push = before.push - stiffness * reading.gap;
  ContactAnswer<Scalar> now{{push > 0 ? push : Scalar(0), {}}, 0};
  if (friction > 0 && push > 0) {
    const Vec3<Scalar> drag = before.drag - stiffness * reading.slip;
    const Scalar square = dot(drag, drag), most = friction * push;
    now.sticking = square > most * most ? most / sqrt(square) : Scalar(1);
    now.force.drag = now.sticking * drag;
  }
  return now;
}

}  // namespace pbdsurg
