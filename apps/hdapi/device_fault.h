// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What goes wrong with a haptic device while it is in use, counted and named.

#include <array>
#include <cstddef>
#include <cstdint>

namespace rig {

/// Each is counted for the device that it happened to.
enum class DeviceFault : std::uint8_t {
  // force goes to zero; the next tick without a fault is ready again, for the safety chain to let
  // it in
  warm_motors,              ///< let them cool
  exceeded_force,           ///< more was commanded than the device has
  exceeded_impulse,         ///< the force changed too fast
  exceeded_velocity,        ///< the stylus was thrown or dropped
  force_error,              ///< any other of the motors
  bad_call,                 ///< a call that HDAPI refused: a defect of the program
  bad_reading,              ///< a pose that is no number or no rotation
  simulation_not_a_number,  ///< the force callback returned NaN or an infinity
  clock_jump,               ///< no tick for 100 ms by the clock, or time ran backwards

  // nothing but the count: the force of the tick before stays for as long
  late_tick,     ///< by half a period or more
  dropped_tick,  ///< one for each that should have been

  // force stays off until the device is calibrated
  stuck_calibration,  ///< updates that did not help

  // the device is lost: force goes to zero and stays there
  lost_communication,
  device_failure,     ///< unplugged, or broken
  wrong_handle,       ///< HDAPI no longer knows the device
  scheduler_failure,  ///< the timer, or the licence
  swapped_devices,    ///< its serial number is another's; found at the start, they are exchanged
};

inline constexpr std::size_t kDeviceFaultCount = 17;

/// For people: "lost communication".
[[nodiscard]] const char* name_of(DeviceFault fault) noexcept;

/// Whether a device is lost by it.
[[nodiscard]] constexpr bool is_fatal(DeviceFault fault) {
  return fault >= DeviceFault::lost_communication;
}

/// Whether force is off for some time, or for good, after it.
[[nodiscard]] constexpr bool stops_force(DeviceFault fault) {
  return fault != DeviceFault::late_tick && fault != DeviceFault::dropped_tick;
}

/// How often each happened; one that lasts, in how many ticks. A device is lost once.
class FaultCounts {
 public:
  void add(DeviceFault fault, std::uint64_t count = 1) { counts_[index(fault)] += count; }
  [[nodiscard]] std::uint64_t of(DeviceFault fault) const { return counts_[index(fault)]; }

 private:
  [[nodiscard]] static std::size_t index(DeviceFault fault) {
    return static_cast<std::size_t>(fault);
  }
  std::array<std::uint64_t, kDeviceFaultCount> counts_{};
};

}  // namespace rig
