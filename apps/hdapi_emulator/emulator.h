// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The rear side of the emulated HDAPI: plugs in devices, moves hands, breaks things and tells what
/// was commanded. Programs that drive devices see HD/hd.h alone.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"

namespace hdapi_emulator {

/// What can go wrong on a rig.
enum class Fault : std::uint8_t {
  lost_communication,  ///< the device is there and does not answer: HD_COMM_ERROR
  dropped_tick,        ///< the scheduler leaves ticks out
  late_tick,           ///< ticks begin late by 0.7 of a period
  warm_motors,         ///< HD_WARM_MOTORS, and no force
  stuck_calibration,   ///< updates do not help
  wrong_handle,        ///< HDAPI no longer knows the handle of the device: HD_BAD_HANDLE
  force_error,         ///< HD_FORCE_ERROR, and no force
  unplugged,           ///< in the middle of whatever the hand does: HD_DEVICE_FAULT
  simulation_nan,      ///< above HDAPI: the force that is asked for is no number
  stale_packets,       ///< above HDAPI: the simulation publishes no more
  clock_jump,          ///< the program's clock leaps by kClockJump, as after a suspension
  swapped_devices,     ///< the first two devices answer with each other's serial number
};

inline constexpr std::size_t kFaultCount = 12;
inline constexpr double kClockJump = 5;  ///< s

/// For people: "lost communication".
[[nodiscard]] const char* name_of(Fault fault) noexcept;

/// A fault, from a time on.
struct FaultPlan {
  Fault fault;
  double begin;                                               ///< s, by the scheduler's time
  double duration = std::numeric_limits<double>::infinity();  ///< s; of a jump, it has none
  int device = 0;  ///< of those faults that are a device's
};

/// What a person does with a stylus at one time.
struct Hand {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();         ///< m, where the hand wants the tip
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   ///< of the stylus
  Eigen::Vector3d gimbal_angles = Eigen::Vector3d::Zero();  ///< rad
  double stiffness = 0;                                     ///< N/m; 0 where it does not hold it
  double damping = 0;                                       ///< N s/m
  int buttons = 0;                                          ///< a mask of HD_DEVICE_BUTTON_...
  bool is_in_inkwell = false;                               ///< the stylus is parked
};

/// @param time  s, by the scheduler's time
using HandScript = std::function<Hand(double time)>;

/// How a device comes up.
enum class CalibrationNeed : std::uint8_t {
  none,     ///< it is calibrated
  update,   ///< hdUpdateCalibration() will do
  inkwell,  ///< the stylus must be parked first
};

inline constexpr double kTouchResolution = 0.055e-3;   ///< m
inline constexpr double kTouchXResolution = 0.009e-3;  ///< m, of a finer device

/// A device: a point mass with friction at the end of a stylus. Defaults are near a Touch: peak and
/// continuous force, workspace and resolution as published for it, mass and friction from users.
struct DeviceOptions {
  std::string name = "Default Device";  ///< as a person called it in the vendor's setup tool
  std::string serial_number = "EMULATED-1";
  std::string model = "Touch";
  double resolution = kTouchResolution;                 ///< m, of the encoders
  double mass = 0.045;                                  ///< kg
  double damping = 0.3;                                 ///< N s/m
  double friction = 0.26;                               ///< N
  double max_force = 3.3;                               ///< N
  double max_continuous_force = 0.88;                   ///< N
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   ///< m, where it begins
  CalibrationNeed calibration = CalibrationNeed::none;  ///< else positions are off by 20 mm
  bool has_extras = true;  ///< gimbal angles, inkwell switch, motor temperature: not all models do
  HandScript hand{};       ///< without one, nobody holds it
};

/// Whom hdGetError() hands an error to. The vendor's documentation leaves that open, so a driver
/// must live with both.
enum class ErrorStack : std::uint8_t {
  global,      ///< to whoever asks first
  per_thread,  ///< to the thread that made it
};

/// What is plugged in and how time passes.
struct EmulatorOptions {
  std::vector<DeviceOptions> devices{DeviceOptions{}};
  bool has_real_time = false;  ///< a thread at 1000 Hz; else ticks happen when clock() is waited on
  ErrorStack error_stack = ErrorStack::global;
};

/// A force at one frame of a device.
struct ForceRecord {
  double time;               ///< s, by the scheduler's time
  Eigen::Vector3d set;       ///< N, by the driver
  Eigen::Vector3d applied;   ///< N, by the motors: after the driver's limits and errors
  Eigen::Vector3d position;  ///< m, of the tip in truth
};

class Engine;

/// What HDAPI finds while this object lives. One at a time; any thread may call its functions.
class Emulator {
 public:
  /// @throws pbdsurg::InvalidArgument  if an option is out of range, two devices have one name, or
  ///                                   another emulator lives
  explicit Emulator(const EmulatorOptions& options = {});
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;
  ~Emulator();  ///< stops the scheduler

  /// The clock of programs on this rig. In virtual time, waiting on it makes the scheduler tick, in
  /// the thread that waits.
  [[nodiscard]] pbdsurg::Clock& clock() noexcept;

  /// s since this was made, by a clock that does not jump: that of plans and records.
  [[nodiscard]] double scheduler_time() const;

  /// In virtual time: lets time pass, a tick a millisecond, whether the scheduler runs or not.
  /// @throws pbdsurg::InvalidArgument  in real time, or if `ticks` is negative
  void step(int ticks);

  /// Lets something go wrong. Plans add up.
  /// @throws pbdsurg::InvalidArgument  if there is no such device, or a time is negative
  void inject(const FaultPlan& plan);

  /// Whether a fault is in force now: for those above HDAPI, which the program plays itself.
  [[nodiscard]] bool is_active(Fault fault, int device = 0) const;

  /// All forces of a device so far, a record for each frame.
  [[nodiscard]] std::vector<ForceRecord> forces(int device = 0) const;

  /// m, where the tip of a device is in truth.
  [[nodiscard]] Eigen::Vector3d position(int device = 0) const;

  /// Devices that are open, callbacks that are scheduled, errors that nobody took: 0 after a clean
  /// end of a driver.
  [[nodiscard]] int open_device_count() const;
  [[nodiscard]] int callback_count() const;
  [[nodiscard]] int error_count() const;
  [[nodiscard]] bool is_running() const;  ///< whether the scheduler is

  /// HDAPI's calls so far that change something, in order, those of ticks left out: "hdInitDevice",
  /// ...
  [[nodiscard]] std::vector<std::string> calls() const;

 private:
  std::unique_ptr<Engine> engine_;
};

}  // namespace hdapi_emulator
