// SPDX-License-Identifier: Apache-2.0
// Arms of a build without HDAPI.
#include "apps/rig/arms.h"

namespace rig {

std::unique_ptr<Arms> open_arms(const std::vector<ArmOptions>&, bool, pbdsurg::Clock&) {
  throw pbdsurg::BackendUnavailable(
      "this build has no haptic arms: configure with -D PBDSURG_HDAPI=auto");
}

}  // namespace rig
