// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What servos are told of the tissue around both instruments.

#include <array>
#include <cstdint>

#include "pbdsurg/contact/contact_probe.h"

#include "apps/cholecystectomy/simulation.h"

namespace cholecystectomy {

/// Of the grasper and of the hook.
using ContactPatches = std::array<pbdsurg::ContactPatch*, 2>;

/// Watches the tips, and what of the shafts may touch first.
class InstrumentContacts {
 public:
  explicit InstrumentContacts(const Simulation& simulation);

  /// After a step, in its thread.
  /// @param grasp     of the grasper
  /// @param sequence  ascending
  /// @param time      s, of the servos' clock
  /// @param patches   filled; null where nobody asks
  void collect(const Simulation& simulation, pbdsurg::GraspState grasp, std::uint64_t sequence,
               double time, const ContactPatches& patches);

 private:
  std::array<pbdsurg::ContactProbe, 2> probes_;  // of the grasper, of the hook
};

/// In any thread. Jaws hold with a spring that knows nothing of the tissue's stiffness: the servo
/// learns it from the force. Half spaces of an organ's wall, as planes have them, are far stiffer
/// than a hollow organ that is pulled.
[[nodiscard]] pbdsurg::ContactPacket packet_of(const pbdsurg::ContactPatch& patch);

}  // namespace cholecystectomy
