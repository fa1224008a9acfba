// SPDX-License-Identifier: Apache-2.0
// The emulator of a build without one.
#include "apps/rig/emulated_rig.h"

namespace rig {

std::unique_ptr<EmulatedRig> emulate(const RigDescription&, const RigPlaces&, bool) {
  throw pbdsurg::BackendUnavailable(
      "this build has no emulator of haptic arms: configure with -D PBDSURG_HDAPI=emulator");
}

}  // namespace rig
