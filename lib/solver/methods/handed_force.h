// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a tool slides from an edge to a triangle beside it, one contact goes and another comes,
/// which vertex blocks would meet without a force: tissue would give way for a substep, go back to
/// the edge, and tremble. So the new one begins with the force of the one that is gone.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/state/surface_contact.h"

namespace pbdsurg {

PBDSURG_HOST_DEVICE inline bool share_corner(const ContactFeature& a, const ContactFeature& b) {
  for (const Index place : a.places) {
    for (const Index other : b.places) {
      if (place == other && place != kInvalidIndex) {
        return true;
      }
    }
  }
  return false;
}

/// Whether a contact may take over a force: its feature was not met in the substep before, and
/// meets a rod, or a plate that moves. Under one at rest contacts come and go without end, and
/// would hand over what makes them do so.
PBDSURG_HOST_DEVICE inline bool may_take_over(bool was_met, const SweptCapsule& capsule) {
  constexpr float kAtRest = 0.01F;  // radii in the substep
  return !was_met && (!capsule.now.is_plate() || capsule.relative_way() > kAtRest);
}

/// The contact that takes over the force of one that is gone: of those that may and have a corner
/// in common with it, the first whose normal is nearest to its own, within 60 degrees.
struct HandedForce {
  Index taker = kInvalidIndex;
  float share = 0.5F;  ///< of the force, along the taker's normal

  PBDSURG_HOST_DEVICE void consider(const RememberedContact& gone, const SurfaceContact& contact,
                                    Index index) {
    if (!contact.takes_over || !share_corner(gone.feature, contact.feature)) {
      return;
    }
    const float along = dot(gone.normal, contact.normal);
    if (along > share) {
      taker = index;
      share = along;
    }
  }
};

}  // namespace pbdsurg
