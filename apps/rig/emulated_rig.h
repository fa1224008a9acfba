// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Arms, jaws and pedals without hardware, in hands that follow a script.

#include <memory>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/scripted_hand.h"

#include "apps/rig/rig_description.h"
#include "apps/rig/rig_places.h"

namespace rig {

/// What HDAPI and the kernel find while this lives. One at a time.
class EmulatedRig {
 public:
  virtual ~EmulatedRig() = default;

  /// Of all that runs on this rig.
  [[nodiscard]] virtual pbdsurg::Clock& clock() = 0;

  /// In virtual time: a millisecond passes, and servos tick.
  virtual void tick() = 0;

  /// The emulated keyboard under the feet, with the keys that it has.
  [[nodiscard]] virtual PedalsDescription pedals() const = 0;

  /// A hand follows a script from now on, with spring and damper, so that forces move it. It rests
  /// before the first script. Buttons close the jaws below a half. Any one thread.
  virtual void rehearse(Side side, std::vector<pbdsurg::Waypoint> waypoints) = 0;

  /// The first scene begins: from now on count the times of faults. Once.
  virtual void begin() = 0;

  /// Faults above the arms, which the program plays: packets that stop, or are no numbers.
  [[nodiscard]] virtual bool is_stale(Side side) const = 0;
  [[nodiscard]] virtual bool is_not_a_number(Side side) const = 0;
};

/// Hands rest at their places.
/// @throws pbdsurg::InvalidArgument     naming the fault that there is not
/// @throws pbdsurg::BackendUnavailable  if this build has no emulator
[[nodiscard]] std::unique_ptr<EmulatedRig> emulate(const RigDescription& description,
                                                   const RigPlaces& places, bool has_virtual_time);

}  // namespace rig
