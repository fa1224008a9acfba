// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where instruments and scope come in: the ports of an operation in the usual position.

#include <Eigen/Core>

#include "apps/cholecystectomy/play/hand.h"
#include "apps/cholecystectomy/scope.h"
#include "apps/rig/rig.h"

namespace cholecystectomy {

/// m, and m: the ball that tips of a mouse's hands stay in.
inline const Eigen::Vector3f kCentre(0.03F, 0, 0);
inline constexpr float kReach = 0.14F;

/// In the picture from below left and right, the tips before the organs.
[[nodiscard]] rig::RigPlaces hand_places();

/// What a hand may reach from the port on its side.
[[nodiscard]] Reach reach_of(rig::Side side);

/// Through the navel, at the gallbladder.
[[nodiscard]] Scope first_scope();

}  // namespace cholecystectomy
