// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a simulator asks of the thing in a hand: a mouse, a haptic arm, a recorded trace.

#include <Eigen/Geometry>
#include <cstdint>
#include <string>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Two foot switches, as an electrosurgical generator has them.
struct Pedals {
  bool cut = false;          ///< yellow
  bool coagulation = false;  ///< blue

  /// Whether the same are down.
  friend bool operator==(const Pedals&, const Pedals&) = default;
};

/// What pedals ask of a generator.
enum class Activation : std::uint8_t {
  none,         ///< no pedal, or both: a generator refuses two at once
  cut,          ///< continuous current
  coagulation,  ///< bursts
};

/// The one that is down alone.
[[nodiscard]] PBDSURG_API Activation activation_of(const Pedals& pedals) noexcept;

/// A hand at one time.
struct DeviceState {
  double time = 0;  ///< s, by the clock that the device was made with, when this was so
  Eigen::Isometry3f pose =
      Eigen::Isometry3f::Identity();  ///< of the instrument in the scene, m: the
                                      ///< tip at the origin, the shaft along +z
  float jaw = 1;                      ///< 0 closed to 1 open
  std::uint32_t buttons = 0;          ///< bit i: button i is down
  Pedals pedals{};                    ///< of those wired to this device; off where there are none
  bool is_connected = true;           ///< else the rest is the last that was known, pedals off
};

/// One hand's device. Functions are called from one thread, and none of them waits.
class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;             ///< a device is one thing
  Device& operator=(const Device&) = delete;  ///< likewise
  virtual ~Device() = default;

  /// For a person: "mouse", "Touch (left)".
  [[nodiscard]] virtual std::string name() const = 0;

  /// The newest state that is known.
  [[nodiscard]] virtual DeviceState state() noexcept = 0;

  /// What the hand should feel until the next call. Devices without motors leave it.
  /// @param force  N, in the scene's axes
  virtual void set_force(const Eigen::Vector3f& force) noexcept { static_cast<void>(force); }
};

}  // namespace pbdsurg
