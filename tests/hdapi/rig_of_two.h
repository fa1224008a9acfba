// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Two emulated Touch devices in two hands, and the little of a simulation that they feel.

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"

namespace rig::testing {

inline constexpr float kStiffness = 180;  ///< N/m, of the wall that hands press on
inline constexpr float kDepth = 0.01f;    ///< m, that they are in it

/// Hands rest at x = +-50 mm and press 10 mm deep into a wall at y = 0.
inline hdapi_emulator::EmulatorOptions two_hands() {
  hdapi_emulator::EmulatorOptions options;
  options.devices.clear();
  for (const bool is_left : {true, false}) {
    hdapi_emulator::DeviceOptions device;
    device.name = is_left ? "Left Device" : "Right Device";
    device.serial_number = is_left ? "L" : "R";
    device.position = {is_left ? -0.05 : 0.05, -kDepth, 0};
    device.hand = [start = device.position, is_left](double) {
      return hdapi_emulator::Hand{.target = start,
                                  .gimbal_angles = {0.1, 0.2, 0.3},
                                  .stiffness = 1000,
                                  .damping = 10,
                                  .buttons = is_left ? 1 : 2};
    };
    options.devices.push_back(device);
  }
  return options;
}

/// A force without a safety chain: that of a wall, at once and whatever the driver says.
class Wall {
 public:
  explicit Wall(const hdapi_emulator::Emulator& emulator, int device = 0)
      : emulator_(&emulator), device_(device) {}

  /// N
  Eigen::Vector3f force(const HdapiTick& tick) const {
    if (emulator_->is_active(hdapi_emulator::Fault::simulation_nan, device_)) {
      return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
    return {0, kStiffness * std::max(0.0f, -tick.pose.translation().y()), 0};
  }

 private:
  const hdapi_emulator::Emulator* emulator_;
  int device_;
};

/// Both devices, of which each feels a wall of its own.
/// @tparam Feeling  Wall, or WallServo
template <class Feeling>
std::vector<HdapiDeviceOptions> feel(Feeling& left, Feeling& right) {
  return {{.label = "left",
           .name = "Left Device",
           .serial_number = "L",
           .force = [&left](const HdapiTick& tick) { return left.force(tick); }},
          {.label = "right",
           .name = "Right Device",
           .serial_number = "R",
           .force = [&right](const HdapiTick& tick) { return right.force(tick); }}};
}

}  // namespace rig::testing
