// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Haptic arms, as far as this build has them.

#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/device.h"
#include "pbdsurg/haptics/instrument_mapping.h"

#include "apps/hdapi/hdapi_device.h"
#include "apps/rig/hand_servo.h"

namespace rig {

/// Which arm, and the servo that ticks with it.
struct ArmOptions {
  std::string label;          ///< for people: "left"
  std::string name;           ///< as in the vendor's setup tool; empty: its default device
  std::string serial_number;  ///< that it must have; empty: any
  pbdsurg::InstrumentMapping mapping;
  HandServo* servo;  ///< outlives the arms
};

/// Open arms, whose servos tick at 1000 Hz until this is destroyed.
class Arms {
 public:
  virtual ~Arms() = default;
  /// In the axes of the arm; of the thread that asks for states, as status().
  [[nodiscard]] virtual pbdsurg::Device& device(int index) = 0;
  [[nodiscard]] virtual HdapiStatus status(int index) = 0;
  [[nodiscard]] virtual const HdapiLimits& limits(int index) = 0;
  /// About once a second: goes on with calibrations.
  virtual void poll() = 0;
};

/// @throws pbdsurg::BackendUnavailable  if this build has no arms, or not those that are asked for,
///                                      or one does not open
/// @throws pbdsurg::InvalidArgument     as HdapiSession
[[nodiscard]] std::unique_ptr<Arms> open_arms(const std::vector<ArmOptions>& arms,
                                              bool are_emulated, pbdsurg::Clock& clock);

}  // namespace rig
