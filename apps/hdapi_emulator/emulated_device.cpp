// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi_emulator/emulated_device.h"

#include <algorithm>
#include <cmath>

namespace hdapi_emulator {
namespace {

constexpr int kSubsteps = 10;                   // of a tick, for the mechanics
constexpr double kVelocityCutoff = 50;          // Hz, of the driver's smoothing
constexpr double kUncalibrated = 20e-3;         // m, by which positions are off
constexpr double kTransformError = 1e-5;        // by which axes are neither unit nor orthogonal
constexpr double kMillimetres = 1000;           // a metre
constexpr double kWarmUp = 10;                  // s, to about the temperature of the force
constexpr std::size_t kRecordCount = 1u << 16;  // that fit before the recorder allocates

int write(const Eigen::Vector3d& vector, double* values) {
  std::copy_n(vector.data(), 3, values);
  return 3;
}

template <class Value>
int write(Value value, Value* values) {
  *values = value;
  return 1;
}

}  // namespace

EmulatedDevice::EmulatedDevice(const DeviceOptions& options)
    : options_(options), position_(options.position), calibration_(options.calibration) {
  if (options_.hand) {
    hand_ = options_.hand(0);
  }
  encoders_ = measured();
  forces_.reserve(kRecordCount);
  close();
}

void EmulatedDevice::open() {
  is_open_ = true;
  capabilities_ = {{HD_FORCE_OUTPUT, false},           {HD_MAX_FORCE_CLAMPING, true},
                   {HD_FORCE_RAMPING, true},           {HD_SOFTWARE_FORCE_LIMIT, true},
                   {HD_SOFTWARE_VELOCITY_LIMIT, true}, {HD_SOFTWARE_FORCE_IMPULSE_LIMIT, true},
                   {HD_ONE_FRAME_LIMIT, true}};
}

void EmulatedDevice::close() {
  is_open_ = false;
  depth_ = 0;
  stop_force();
  sample_ = {encoders_,      smooth_velocity_, hand_.gimbal_angles,
             hand_.rotation, hand_.buttons,    hand_.is_in_inkwell};
}

/// What the encoders show, m.
Eigen::Vector3d EmulatedDevice::measured() const {
  Eigen::Vector3d shown = position_;
  if (calibration_ != CalibrationNeed::none) {
    shown.x() += kUncalibrated;
  }
  return (shown / options_.resolution).array().round().matrix() * options_.resolution;
}

void EmulatedDevice::advance(double time, double seconds, const ActiveFaults& faults) {
  if (options_.hand) {
    hand_ = options_.hand(time);
  }
  if (faults.is_silent()) {
    stop_force();  // the amplifier switches off by itself
  }
  const double dt = seconds / kSubsteps;
  for (int substep = 0; substep < kSubsteps; ++substep) {
    const Eigen::Vector3d force = applied_ + hand_.stiffness * (hand_.target - position_) -
                                  (hand_.damping + options_.damping) * velocity_;
    velocity_ += dt / options_.mass * force;
    // dry friction takes speed away, and never turns it round
    const double lost = dt * options_.friction / options_.mass;
    const double speed = velocity_.norm();
    velocity_ *= speed > lost ? 1 - lost / speed : 0;
    position_ += dt * velocity_;
  }
  const Eigen::Vector3d before = encoders_;
  encoders_ = measured();
  const double share = 1 - std::exp(-2 * M_PI * kVelocityCutoff * seconds);
  smooth_velocity_ += share * ((encoders_ - before) / seconds - smooth_velocity_);
  const double heat = applied_.norm() / options_.max_continuous_force;
  temperature_ += seconds / kWarmUp * (std::min(heat, 1.0) - temperature_);
  if (faults.has_warm_motors) {
    temperature_ = 1;
  }
}

void EmulatedDevice::begin_frame(const ActiveFaults& faults, Errors& errors) {
  if (depth_ == 0 && frame_count_ > 0 && is_enabled(HD_ONE_FRAME_LIMIT)) {
    errors.push_back(HD_ILLEGAL_BEGIN);
    return;
  }
  if (depth_++ > 0) {
    return;
  }
  ++frame_count_;
  set_.setZero();
  if (faults.is_unplugged) {
    errors.push_back(HD_DEVICE_FAULT);
  } else if (faults.has_lost_communication) {
    errors.push_back(HD_COMM_ERROR);
  } else {
    sample_ = {encoders_,      smooth_velocity_, hand_.gimbal_angles,
               hand_.rotation, hand_.buttons,    hand_.is_in_inkwell};
  }
}

void EmulatedDevice::end_frame(double time, const ActiveFaults& faults, Errors& errors) {
  if (depth_ == 0) {
    errors.push_back(HD_ILLEGAL_END);
    return;
  }
  if (--depth_ > 0) {
    return;
  }
  applied_ = limited(time, faults, errors);
  set_before_ = set_;
  forces_.push_back({time, set_, applied_, position_});
}

/// What the motors make of the force that was set, N.
Eigen::Vector3d EmulatedDevice::limited(double time, const ActiveFaults& faults, Errors& errors) {
  if (faults.is_silent() || !is_enabled(HD_FORCE_OUTPUT)) {
    return Eigen::Vector3d::Zero();
  }
  Eigen::Vector3d force = set_;
  const std::size_t error_count = errors.size();
  if (faults.has_warm_motors) {
    errors.push_back(HD_WARM_MOTORS);
  }
  if (faults.has_force_error || !force.allFinite()) {
    errors.push_back(HD_FORCE_ERROR);
  }
  if (is_enabled(HD_SOFTWARE_VELOCITY_LIMIT) &&
      smooth_velocity_.norm() * kMillimetres > velocity_limit_) {
    errors.push_back(HD_EXCEEDED_MAX_VELOCITY);
  }
  if (force.norm() > options_.max_force) {
    if (is_enabled(HD_MAX_FORCE_CLAMPING)) {
      force *= options_.max_force / force.norm();
    } else if (is_enabled(HD_SOFTWARE_FORCE_LIMIT)) {
      errors.push_back(HD_EXCEEDED_MAX_FORCE);
    }
  }
  if (is_enabled(HD_SOFTWARE_FORCE_IMPULSE_LIMIT) && (set_ - set_before_).norm() > impulse_limit_) {
    errors.push_back(HD_EXCEEDED_MAX_FORCE_IMPULSE);
  }
  if (errors.size() > error_count) {
    start_force(time);  // anew, when it is over
    return Eigen::Vector3d::Zero();
  }
  const double ramp = ramping_rate_ * (time - ramp_begin_);
  if (is_enabled(HD_FORCE_RAMPING) && force.norm() > ramp) {
    force *= ramp / force.norm();
  }
  return force;
}

void EmulatedDevice::end_tick(Errors& errors) {
  if (depth_ > 0) {
    depth_ = 0;
    errors.push_back(HD_FRAME_ERROR);
  }
}

bool EmulatedDevice::is_capability(HDenum capability) const {
  return capabilities_.count(capability) != 0;
}

bool EmulatedDevice::is_enabled(HDenum capability) const {
  const auto found = capabilities_.find(capability);
  return found != capabilities_.end() && found->second;
}

void EmulatedDevice::enable(HDenum capability, bool is_enabled) {
  capabilities_[capability] = is_enabled;
}

int EmulatedDevice::get(HDenum parameter, HDdouble* values) const {
  if (!options_.has_extras &&
      (parameter == HD_CURRENT_GIMBAL_ANGLES || parameter == HD_MOTOR_TEMPERATURE)) {
    return 0;
  }
  switch (parameter) {
    case HD_CURRENT_POSITION:
      return write(sample_.position * kMillimetres, values);
    case HD_CURRENT_TRANSFORM:
      for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
          values[4 * column + row] = sample_.rotation(row, column) + kTransformError * (1 + column);
        }
        values[4 * column + 3] = 0;
      }
      write(sample_.position * kMillimetres, values + 12);
      values[15] = 1;
      return 16;
    case HD_CURRENT_VELOCITY:
      return write(sample_.velocity * kMillimetres, values);
    case HD_CURRENT_ANGULAR_VELOCITY:
    case HD_CURRENT_JOINT_ANGLES:
      return write(Eigen::Vector3d::Zero(), values);  // hands have none
    case HD_CURRENT_GIMBAL_ANGLES:
      return write(sample_.gimbal_angles, values);
    case HD_CURRENT_FORCE:
      return write(set_, values);
    case HD_NOMINAL_MAX_FORCE:
      return write(options_.max_force, values);
    case HD_NOMINAL_MAX_CONTINUOUS_FORCE:
      return write(options_.max_continuous_force, values);
    case HD_NOMINAL_MAX_STIFFNESS:
      return write(0.5, values);  // what a program printed for a Touch
    case HD_NOMINAL_MAX_DAMPING:
      return write(0.004, values);  // CHAI3D's limit for it, 4 N s/m, in N s/mm
    case HD_USABLE_WORKSPACE_DIMENSIONS:
    case HD_MAX_WORKSPACE_DIMENSIONS:
      write({-80, -60, -35}, values);
      write({80, 60, 35}, values + 3);
      return 6;
    case HD_MOTOR_TEMPERATURE:
      return write(Eigen::Vector3d::Constant(temperature_), values);
    case HD_FORCE_RAMPING_RATE:
      return write(ramping_rate_, values);
    case HD_SOFTWARE_FORCE_IMPULSE_LIMIT:
      return write(impulse_limit_, values);
    case HD_SOFTWARE_VELOCITY_LIMIT:
      return write(velocity_limit_, values);
    default:
      return 0;
  }
}

int EmulatedDevice::get(HDenum parameter, HDint* values) const {
  switch (parameter) {
    case HD_CURRENT_BUTTONS:
      return write(sample_.buttons, values);
    case HD_UPDATE_RATE:
    case HD_INSTANTANEOUS_UPDATE_RATE:
      return write(1000, values);
    case HD_CALIBRATION_STYLE:
      return write<HDint>(HD_CALIBRATION_INKWELL, values);
    default:
      return 0;
  }
}

int EmulatedDevice::get(HDenum parameter, HDboolean* values) const {
  switch (parameter) {
    case HD_CURRENT_INKWELL_SWITCH:
      if (!options_.has_extras) {
        return 0;
      }
      return write(sample_.is_in_inkwell ? HD_TRUE : HD_FALSE, values);
    case HD_CURRENT_SAFETY_SWITCH:
      return write(HD_TRUE, values);  // a Touch has none
    default:
      return 0;
  }
}

bool EmulatedDevice::set_doubles(HDenum parameter, const HDdouble* values) {
  switch (parameter) {
    case HD_CURRENT_FORCE:
      set_ = Eigen::Vector3d(values[0], values[1], values[2]);
      return true;
    case HD_FORCE_RAMPING_RATE:
      ramping_rate_ = values[0];
      return true;
    case HD_SOFTWARE_FORCE_IMPULSE_LIMIT:
      impulse_limit_ = values[0];
      return true;
    case HD_SOFTWARE_VELOCITY_LIMIT:
      velocity_limit_ = values[0];
      return true;
    default:
      return false;
  }
}

HDenum EmulatedDevice::check_calibration(const ActiveFaults& faults) const {
  if (faults.has_stuck_calibration) {
    return HD_CALIBRATION_NEEDS_UPDATE;
  }
  switch (calibration_) {
    case CalibrationNeed::none:
      return HD_CALIBRATION_OK;
    case CalibrationNeed::inkwell:
      if (!hand_.is_in_inkwell) {
        return HD_CALIBRATION_NEEDS_MANUAL_INPUT;
      }
      [[fallthrough]];
    case CalibrationNeed::update:
      break;
  }
  return HD_CALIBRATION_NEEDS_UPDATE;
}

void EmulatedDevice::update_calibration(HDenum style, const ActiveFaults& faults, Errors& errors) {
  if (style != HD_CALIBRATION_INKWELL) {
    errors.push_back(HD_INVALID_VALUE);
  } else if (check_calibration(faults) == HD_CALIBRATION_NEEDS_UPDATE &&
             !faults.has_stuck_calibration) {
    calibration_ = CalibrationNeed::none;
    encoders_ = measured();  // the leap is no motion
  }
}

}  // namespace hdapi_emulator
