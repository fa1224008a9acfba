// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What of tissue meets a tool: a vertex, an edge or a triangle, for which the tool is a plane.

#include <compare>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// Places of a vertex, an edge or a triangle, ascending, and kInvalidIndex behind them: its slot in
/// all lists of contacts, which are in the order of these.
struct ContactFeature {
  Index places[3] = {kInvalidIndex, kInvalidIndex, kInvalidIndex};

  [[nodiscard]] PBDSURG_HOST_DEVICE int count() const noexcept {
    return places[1] == kInvalidIndex ? 1 : (places[2] == kInvalidIndex ? 2 : 3);
  }
  /// Makes places ascend.
  PBDSURG_HOST_DEVICE void sort() noexcept {
    const auto order = [this](int k) {
      if (places[k + 1] != kInvalidIndex && places[k + 1] < places[k]) {
        const Index smaller = places[k + 1];
        places[k + 1] = places[k];
        places[k] = smaller;
      }
    };
    order(0);
    order(1);
    order(0);
  }
  auto operator<=>(const ContactFeature& other) const noexcept = default;
};

/// A feature near a capsule. It keeps
///
///     C = normal . sum(weights * u) - offset >= 0    m
///
/// with u the displacements of its corners since the start of the substep, in fraction mode their
/// positions. Its gradient at a corner is weight * normal: where the feature is nearest to the
/// capsule, what the weights themselves change adds nothing to first order. After each sweep of
/// vertex blocks the plane is turned to where the feature is, see turn_to(); the stiffness stays.
struct SurfaceContact {
  ContactFeature feature;
  Index capsule = kInvalidIndex;  ///< of the tool; kInvalidIndex: a half space
  float weights[3] = {};          ///< of its corners at the point that touches; zero behind them
  Vec3<float> normal;             ///< out of the tool
  float offset = 0;               ///< m
  Vec3<float> point;  ///< m, in the scene, of the tool's surface without ToolSpring::shift
  /// m: sum(weights * u) of tissue that sticks to the tool
  Vec3<float> drift;
  float multiplier = 0;         ///< kg m
  Vec3<float> friction;         ///< kg m, multipliers along the tool's surface
  float stiffness = 0;          ///< N/m, with which vertex blocks meet it
  bool takes_over = false;      ///< the force of one that is gone: see HandedForce
  bool is_left_inside = false;  ///< of the tool, by all that moved its corners
  bool is_eased = false;        ///< with the piece that it touches: see ease_pieces()
  float relief = 0;             ///< 1/s^2, then: see relief_of()
};

/// What a substep leaves to the next of a contact.
struct RememberedContact {
  ContactFeature feature;
  Vec3<float> normal;    ///< out of the tool: the side on which the feature is
  float force = 0;       ///< N, along it
  Vec3<float> friction;  ///< N
};

}  // namespace pbdsurg
