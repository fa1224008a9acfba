// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A hand that goes where a program says.

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/device.h"

namespace pbdsurg {

/// Where a hand is at one time.
struct Waypoint {
  double time = 0;                                                  ///< s, since the hand was made
  Eigen::Vector3f tip = Eigen::Vector3f::Zero();                    ///< m
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();  ///< of unit length
  float jaw = 1;                                                    ///< 0 closed to 1 open
  Pedals pedals{};                                                  ///< from this time on
};

/// A device that passes through waypoints: straight from tip to tip, by the shorter rotation, the
/// jaw evenly, pedals as the last waypoint has them. Before the first it is at the first, after the
/// last at the last; pedals are up before the first.
/// @param clock  outlives the device
/// @throws InvalidArgument  naming the waypoint, if there is none, times do not ascend, a number is
///                          not finite, an orientation is not of unit length (to 1e-3), or a jaw is
///                          outside 0 to 1
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> scripted_hand(std::string name,
                                                                std::vector<Waypoint> waypoints,
                                                                const Clock& clock);

}  // namespace pbdsurg
