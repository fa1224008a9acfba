// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What contacts with tools and contacts between bodies share: a plane, which keeps
///
///     C = normal . sum(weights * u) - offset >= 0    m
///
/// and its multipliers, on a CPU or a device. A Contact is a SurfaceContact or a TissueTouch.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/contact_answer.h"
#include "lib/solver/methods/vertex_moves.h"

namespace pbdsurg {

/// The stiffness of a contact over that of its corners, as far as their neighbours leave them
/// alone. Where a thin tool sinks in, neighbours do not: within the few sweeps of a substep,
/// contacts no stiffer than their corners let edges slip past. A thick one takes neighbours along,
/// and firm contacts with all of these would push by turns too far and not at all. Tissue that
/// nothing holds, and sheets, which have nothing behind them, would be thrown off by firm ones, and
/// so would all that a capsule runs into.
inline constexpr float kPlainFirmness = 1;
inline constexpr float kHeldFirmness = 4;

/// The stiffness of a contact of fixed corners over that of the spring of its tool, which is all
/// that gives way there: what that leaves of the overlap, multipliers take over.
inline constexpr float kWallFirmness = 100;

/// N/m, with which vertex blocks meet a contact with a tool.
/// @param firmness  over what its corners yield
/// @param yield     m/N, of these; zero where all are fixed
/// @param spring    N/m, of the tool; zero of one that goes where it is told
[[nodiscard]] PBDSURG_HOST_DEVICE inline float met_stiffness(float firmness, float yield,
                                                             float spring) {
  return yield > 0 ? firmness / yield : kWallFirmness * spring;
}

/// @param at_rest    of thin capsules that do not move: one of the two
/// @param thickness  of the capsule over the extent of the feature that it meets; to one nothing
///                   changes, from two on firmness is plain
/// @param radii      that it goes in the substep; likewise to a half and from one on
[[nodiscard]] PBDSURG_HOST_DEVICE inline float firmness_of(float at_rest, float thickness,
                                                           float radii) {
  const auto share_of = [](float share) { return share < 1 ? (share > 0 ? share : 0.0F) : 1.0F; };
  const float share = share_of(2 - thickness) * share_of(2 * (1 - radii));
  return kPlainFirmness + share * (at_rest - kPlainFirmness);
}

/// After the sweeps of vertex blocks, how often contacts at most are gone through, while any is
/// inside: each may push others, with which it shares corners, back in.
inline constexpr int kSettlePasses = 8;

/// @param sum  m, sum(weights * u) now
template <class Contact>
[[nodiscard]] PBDSURG_HOST_DEVICE inline ContactReading<float> read_plane(const Contact& contact,
                                                                          const Vec3<float>& sum) {
  const Vec3<float> way = sum - contact.drift;
  return {dot(contact.normal, sum) - contact.offset,
          way - dot(contact.normal, way) * contact.normal};
}

/// @param scale  of the contact's multipliers
template <class Contact>
[[nodiscard]] PBDSURG_HOST_DEVICE inline ContactAnswer<float> answer(
    const Contact& contact, float friction, const ContactReading<float>& reading, float scale,
    float stiffness) {
  return contact_answer({scale * contact.multiplier, scale * contact.friction}, friction, reading,
                        stiffness);
}

[[nodiscard]] PBDSURG_HOST_DEVICE inline bool is_finite_force(const ContactForce<float>& force) {
  return force.push < kInfinity && is_finite_way(force.drag);  // it never pulls
}

/// Multipliers become a force, unless that is not finite.
/// @param scale  of the force
template <class Contact>
PBDSURG_HOST_DEVICE inline void take_over(Contact& contact, const ContactForce<float>& force,
                                          float scale) {
  if (is_finite_force(force)) {
    contact.multiplier = scale * force.push;
    contact.friction = scale * force.drag;
  }
}

/// Whether sweeps, and what came after them, left a contact inside: others are against it.
[[nodiscard]] PBDSURG_HOST_DEVICE inline bool is_left_inside(const ContactReading<float>& reading) {
  constexpr float kLeftInside = 1e-5F;  // m
  return reading.gap < -kLeftInside;
}

/// What an answer does at a corner that moves, of vertex blocks.
template <class Contact>
PBDSURG_DEVICE inline void add_answer(const Contact& contact, const ContactAnswer<float>& answer,
                                      float weight, VertexEnergy<float>& energy) {
  const auto& [force, sticking] = answer;
  if (!(force.push > 0)) {
    return;
  }
  const float square = weight * weight * contact.stiffness;
  energy.force = energy.force + weight * (force.push * contact.normal + force.drag);
  energy.isotropic = energy.isotropic + sticking * square;
  energy.add_square((1 - sticking) * square, contact.normal);
}

/// kg, of a contact whose corners move by their masses.
/// @param yield  1/kg, sum(weights^2 * inverse masses)
[[nodiscard]] PBDSURG_HOST_DEVICE inline float stiffness_of(float yield) {
  return yield > 0 ? 1 / yield : 0.0F;
}

/// Whether sweeps of projections may change anything about a contact: others are away from their
/// plane, and nothing pushes them.
/// @param gap  m, that the contact has now
template <class Contact>
[[nodiscard]] PBDSURG_HOST_DEVICE inline bool acts(const Contact& contact, float gap) {
  return gap < 0 || contact.multiplier > 0 || dot(contact.friction, contact.friction) > 0;
}

/// Moves corners by their masses out of the plane.
/// @param stiffness  kg, as of stiffness_of()
/// @param reading    that the contact has now
/// @param move       (push) with push in kg m; not called for no push
template <class Contact, class Move>
PBDSURG_DEVICE inline void push_contact_out(Contact& contact, float stiffness,
                                            const ContactReading<float>& reading,
                                            const Move& move) {
  const ContactForce<float> now = answer(contact, 0, reading, 1, stiffness).force;
  if (stiffness > 0 && is_finite_force(now) && now.push != contact.multiplier) {
    const Vec3<float> push = (now.push - contact.multiplier) * contact.normal;
    contact.multiplier = now.push;
    move(push);
  }
}

/// Likewise, then against the slip.
/// @param read  () -> ContactReading<float>
template <class Contact, class Read, class Move>
PBDSURG_DEVICE inline void project_contact(Contact& contact, float friction, float stiffness,
                                           const Read& read, const Move& move) {
  push_contact_out(contact, stiffness, read(), move);
  if (!(friction > 0) || !(stiffness > 0)) {
    return;
  }
  const ContactForce<float> now = answer(contact, friction, read(), 1, stiffness).force;
  const Vec3<float> drag = now.drag - contact.friction;
  if (is_finite_force(now) && (now.push != contact.multiplier || dot(drag, drag) > 0)) {
    const Vec3<float> push = (now.push - contact.multiplier) * contact.normal + drag;
    contact.multiplier = now.push;
    contact.friction = now.drag;
    move(push);
  }
}

}  // namespace pbdsurg
