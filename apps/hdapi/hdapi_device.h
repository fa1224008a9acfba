// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Haptic arms by HDAPI, the device layer of OpenHaptics: one Touch, or two.

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/device.h"

#include "apps/hdapi/device_fault.h"

namespace rig {

/// A stylus in one tick, in the axes of its device: +x right, +y up, +z to the user. Where it is
/// not ready, pose and buttons are the last that were known, and it does not move.
struct HdapiTick {
  double time;               ///< s, by the session's clock
  Eigen::Isometry3f pose;    ///< m
  Eigen::Vector3f velocity;  ///< m/s, smoothed by the vendor's driver
  std::uint32_t buttons;     ///< bit i: button i is down; a Touch has 0 dark and 1 light
  bool is_ready;             ///< it is calibrated, and had no fault until now since the last tick:
                             ///< else force goes to zero, whatever is asked for
  bool is_warm;              ///< it warns of its motors
};

/// What a hand shall feel, N in the axes of the device: servo_tick(), with its safety chain. Called
/// in each tick by the scheduler's thread, for a lost device too: it may neither wait nor allocate,
/// and if it throws the program ends.
///
/// To let force in slowly, at the start and after a tick that was not ready, is its part. A safety
/// chain does so, and waits until the hand is out of the tissue. Without one, all that the hand is
/// spared is a step: force is there within 13 ms.
using HdapiForce = std::function<Eigen::Vector3f(const HdapiTick& tick)>;

/// Which device, and what it shall do.
struct HdapiDeviceOptions {
  std::string label;            ///< for people: "left"
  std::string name{};           ///< as in the vendor's setup tool; empty for its default device
  std::string serial_number{};  ///< that it must have; empty for any
  HdapiForce force{};           ///< without one, the hand feels nothing
};

/// How a device is calibrated.
enum class HdapiCalibration : std::uint8_t {
  done,
  under_way,      ///< poll() goes on with it
  needs_inkwell,  ///< a person must park the stylus
};

/// What a device can do, by its own account where that can be believed.
struct HdapiLimits {
  float max_force = 0;              ///< N, of cold motors
  float max_continuous_force = 0;   ///< N
  Eigen::AlignedBox3f workspace{};  ///< m
  std::string model{}, serial_number{}, driver{};
};

/// A device at its last tick, beside its DeviceState.
struct HdapiStatus {
  std::uint64_t tick_count = 0;
  HdapiCalibration calibration = HdapiCalibration::under_way;
  bool is_lost = false;                                       ///< it goes on without force
  bool is_in_inkwell = false;                                 ///< the stylus is parked
  float motor_temperature = 0;                                ///< of the warmest, 0 cold to 1 warm
  Eigen::Vector3f gimbal_angles = Eigen::Vector3f::Zero();    ///< rad
  Eigen::Vector3f velocity = Eigen::Vector3f::Zero();         ///< m/s
  Eigen::Vector3f commanded_force = Eigen::Vector3f::Zero();  ///< N
  FaultCounts faults{};
};

/// One arm of a session. Jaws and pedals are other devices: they stay open and up.
///
/// set_force() is left: a force that is held between frames buzzes, so forces come from the
/// callback, in the tick. Of what it asks for, the motors get numbers alone, up to the peak of
/// limits_of_motors(), in steps of 0.2 N a millisecond, and in ticks that are not ready steps to
/// zero (ForceGate).
class HdapiDevice final : public pbdsurg::Device {
 public:
  struct Servo;  ///< what the scheduler's thread works on

  HdapiDevice(std::unique_ptr<Servo> servo, const pbdsurg::Clock& clock);
  ~HdapiDevice() override;

  /// "Touch (left)"
  [[nodiscard]] std::string name() const override;

  /// In the axes of the device. Not connected once the device is lost, or no tick came for 0.25 s.
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override;

  /// Of the thread that calls state().
  [[nodiscard]] HdapiStatus status() noexcept;

  [[nodiscard]] const HdapiLimits& limits() const noexcept;

 private:
  friend class HdapiSession;
  std::unique_ptr<Servo> servo_;
  const pbdsurg::Clock& clock_;
};

/// "emulator" or "OpenHaptics": what this program was linked with.
[[nodiscard]] const char* hdapi_flavour() noexcept;

/// Opens devices and runs them at 1000 Hz by HDAPI's scheduler, until it is destroyed. One a
/// process. After the start only the scheduler's thread calls HDAPI, so the thread that owns the
/// session never waits for it.
class HdapiSession {
 public:
  /// Opens the devices in this order and starts the scheduler. Ticks are ready once a device is
  /// calibrated. Devices that have each other's serial number are exchanged and say so.
  /// @param clock  outlives the session; any thread may read it
  /// @throws pbdsurg::InvalidArgument     if there is none, or two have one name or serial number
  /// @throws pbdsurg::BackendUnavailable  if there is another session, a device or the scheduler
  ///                                      does not start, or a serial number is not asked for
  HdapiSession(std::vector<HdapiDeviceOptions> devices, pbdsurg::Clock& clock);
  HdapiSession(const HdapiSession&) = delete;
  HdapiSession& operator=(const HdapiSession&) = delete;

  /// Lets forces go to zero, for at most 100 ms, and stops.
  ~HdapiSession();

  [[nodiscard]] int device_count() const noexcept;

  /// @param index  as in the constructor's list
  /// @throws pbdsurg::InvalidArgument  if it is not among them
  [[nodiscard]] HdapiDevice& device(int index);

  /// Asks for a look at calibration and serial numbers in the next tick. To be called about once a
  /// second: each look may take the device some time.
  void poll() noexcept;

 private:
  struct Ticker;
  std::unique_ptr<Ticker> ticker_;
};

}  // namespace rig
