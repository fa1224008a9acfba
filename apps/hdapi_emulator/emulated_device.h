// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device of the emulator: its mechanics, its frames, what it does with a force.

#include <Eigen/Core>
#include <map>
#include <vector>

#include <HD/hd.h>

#include "apps/hdapi_emulator/emulator.h"

namespace hdapi_emulator {

/// Errors that a call made, oldest first.
using Errors = std::vector<HDerror>;

inline constexpr int kMostValues = 16;  ///< of a parameter

/// Faults in force, as far as they are about one device.
struct ActiveFaults {
  bool has_lost_communication = false;
  bool has_warm_motors = false;
  bool has_stuck_calibration = false;
  bool has_force_error = false;
  bool is_unplugged = false;

  [[nodiscard]] bool is_silent() const { return has_lost_communication || is_unplugged; }
};

/// Of one thread at a time.
class EmulatedDevice {
 public:
  explicit EmulatedDevice(const DeviceOptions& options);

  [[nodiscard]] const DeviceOptions& options() const { return options_; }
  [[nodiscard]] bool is_open() const { return is_open_; }
  void open();
  void close();

  /// Moves the tip under the hand and the motors.
  /// @param time     s, at the end
  /// @param seconds  s, that pass
  void advance(double time, double seconds, const ActiveFaults& faults);

  /// What the scheduler does at the beginning and at the end of a tick.
  void begin_tick() { frame_count_ = 0; }
  void end_tick(Errors& errors);

  void begin_frame(const ActiveFaults& faults, Errors& errors);
  void end_frame(double time, const ActiveFaults& faults, Errors& errors);

  /// The scheduler begins or ends: so does force.
  void start_force(double time) { ramp_begin_ = time; }
  void stop_force() { applied_.setZero(); }

  [[nodiscard]] bool is_capability(HDenum capability) const;
  [[nodiscard]] bool is_enabled(HDenum capability) const;
  void enable(HDenum capability, bool is_enabled);

  /// @name Values of a parameter
  /// @param values  [kMostValues]
  /// @return  how many it has; 0 where it is not of the type
  /// @{
  [[nodiscard]] int get(HDenum parameter, HDdouble* values) const;
  [[nodiscard]] int get(HDenum parameter, HDint* values) const;
  [[nodiscard]] int get(HDenum parameter, HDboolean* values) const;
  /// @}

  /// @return  whether the parameter can be set
  bool set_doubles(HDenum parameter, const HDdouble* values);

  [[nodiscard]] HDenum check_calibration(const ActiveFaults& faults) const;
  void update_calibration(HDenum style, const ActiveFaults& faults, Errors& errors);

  [[nodiscard]] const std::vector<ForceRecord>& forces() const { return forces_; }
  [[nodiscard]] const Eigen::Vector3d& position() const { return position_; }

 private:
  [[nodiscard]] Eigen::Vector3d limited(double time, const ActiveFaults& faults, Errors& errors);
  [[nodiscard]] Eigen::Vector3d measured() const;

  DeviceOptions options_;
  bool is_open_ = false;
  std::map<HDenum, bool> capabilities_;

  // the mechanics, SI units
  Hand hand_{};
  Eigen::Vector3d position_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d applied_ = Eigen::Vector3d::Zero();  // by the motors, until the next frame
  Eigen::Vector3d smooth_velocity_ = Eigen::Vector3d::Zero();  // of the encoders
  Eigen::Vector3d encoders_;
  CalibrationNeed calibration_;
  double temperature_ = 0;

  // the frame
  int depth_ = 0;
  int frame_count_ = 0;  // of this tick
  struct Sample {
    Eigen::Vector3d position, velocity, gimbal_angles;
    Eigen::Matrix3d rotation;
    int buttons;
    bool is_in_inkwell;
  } sample_;
  Eigen::Vector3d set_ = Eigen::Vector3d::Zero();         // in this frame
  Eigen::Vector3d set_before_ = Eigen::Vector3d::Zero();  // in the one before

  double ramp_begin_ = 0;         // s
  double ramping_rate_ = 40;      // N/s
  double impulse_limit_ = 1;      // N/ms
  double velocity_limit_ = 1500;  // mm/s
  std::vector<ForceRecord> forces_;
};

}  // namespace hdapi_emulator
