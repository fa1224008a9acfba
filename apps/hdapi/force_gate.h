// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The driver's last word on a force, whatever asks for it.

#include <Eigen/Core>
#include <algorithm>

namespace rig {

/// How a gate opens and closes.
struct ForceGateOptions {
  float max_force = 2.6f;   ///< N
  float slew = 200;         ///< N/s, that the force changes by at most
  float ramp_time = 1;      ///< s, from closed to open
  float quiet_time = 0.1f;  ///< s, without a fault before it begins to open
};

/// Lets forces through that are numbers, no greater and no faster than a hand can take. After a
/// fault it closes: force goes to zero at the greatest slew, waits, and comes back by a ramp. It
/// begins closed. A safety chain that obeys the same limits passes unchanged.
///
/// Cost: a few dozen floating-point operations; no allocation.
class ForceGate {
 public:
  /// @param period  s, between calls of pass()
  ForceGate(const ForceGateOptions& options, float period) : options_(options), period_(period) {}

  /// Closes the gate.
  void close() {
    gain_ = 0;
    quiet_ = 0;
  }

  /// The share that passes, 0 closed to 1 open.
  [[nodiscard]] float gain() const { return gain_; }

  /// N, what pass() returned last.
  [[nodiscard]] const Eigen::Vector3f& force() const { return force_; }

  /// The force for this period.
  /// @param wanted  N; if it is no number the gate closes
  /// @return        N; less than max_force, at most slew away from the last
  const Eigen::Vector3f& pass(const Eigen::Vector3f& wanted) {
    Eigen::Vector3f target = wanted;
    if (!target.allFinite()) {
      close();
      target.setZero();
    }
    const float size = target.stableNorm();  // squares of what a broken simulation asks overflow
    if (size > options_.max_force) {
      target *= options_.max_force / size;
    }
    move_to(gain_ * target);
    quiet_ += period_;
    if (quiet_ > options_.quiet_time) {
      gain_ = std::min(1.0f, gain_ + period_ / options_.ramp_time);
    }
    return force_;
  }

  /// The force for this period while the gate is held closed.
  const Eigen::Vector3f& fade() {
    close();
    move_to(Eigen::Vector3f::Zero());
    return force_;
  }

 private:
  void move_to(const Eigen::Vector3f& target) {
    const Eigen::Vector3f step = target - force_;
    const float most = options_.slew * period_;
    const float size = step.norm();
    force_ = size > most ? Eigen::Vector3f(force_ + most / size * step) : target;
  }

  ForceGateOptions options_;
  float period_;
  float gain_ = 0;
  float quiet_ = 0;  // s
  Eigen::Vector3f force_ = Eigen::Vector3f::Zero();
};

}  // namespace rig
