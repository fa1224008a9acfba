// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The driver's last word on a force, whatever asks for it.

#include <Eigen/Core>

#include "pbdsurg/haptics/safety_chain.h"

namespace rig {

/// Lets forces through that are numbers, no greater and no faster than a hand can take: what a
/// driver leaves to nobody else. It slews by SafetyChain::kSlew, so that a safety chain with the
/// same clamp passes unchanged, but for rounding.
///
/// It lets nothing in slowly, as that is the chain's: a ramp here would multiply with the chain's,
/// and would have to know when a hand is out of the tissue, as the chain does.
///
/// Cost: a few dozen floating-point operations; no allocation.
class ForceGate {
 public:
  /// @param max_force  N, positive
  /// @param period     s, between calls of pass(), positive
  ForceGate(float max_force, float period)
      : max_force_(max_force), max_step_(pbdsurg::SafetyChain::kSlew * period) {}

  /// N, what pass() returned last; nothing at first.
  [[nodiscard]] const Eigen::Vector3f& force() const { return force_; }

  /// The force for this period.
  /// @param wanted  N; what is no number is taken for nothing
  /// @return        N; at most max_force, at most the slew away from the last
  const Eigen::Vector3f& pass(const Eigen::Vector3f& wanted) {
    Eigen::Vector3f target = wanted;
    if (!target.allFinite()) {
      target.setZero();
    }
    const float size = target.stableNorm();  // squares of what a broken simulation asks overflow
    if (size > max_force_) {
      target *= max_force_ / size;
    }
    const Eigen::Vector3f step = target - force_;
    const float length = step.norm();
    force_ = length > max_step_ ? Eigen::Vector3f(force_ + max_step_ / length * step) : target;
    return force_;
  }

 private:
  float max_force_, max_step_;                       // N
  Eigen::Vector3f force_ = Eigen::Vector3f::Zero();  // N
};

}  // namespace rig
