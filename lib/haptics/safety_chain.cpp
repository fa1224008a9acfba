// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/safety_chain.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

constexpr float kUsedPeak = 0.8F;     // of what motors can do cold
constexpr float kLargestPeak = 2.6F;  // N, whatever they can do

void check_positive(const char* what, float newtons) {
  if (!(newtons > 0) || !std::isfinite(newtons)) {
    throw InvalidArgument(std::string(what) + " force of a device is " + std::to_string(newtons) +
                          " N; it must be positive and finite");
  }
}

Eigen::Vector3f clamped(const Eigen::Vector3f& force, float largest) {
  const float size = force.norm();
  return size > largest ? Eigen::Vector3f(force * (largest / size)) : force;
}

}  // namespace

const char* name_of(ServoFault fault) noexcept {
  switch (fault) {
    case ServoFault::bad_packet:
      return "bad packet";
    case ServoFault::bad_pose:
      return "bad pose";
    case ServoFault::bad_force:
      return "bad force";
    case ServoFault::device_lost:
      return "device lost";
    case ServoFault::clock_jump:
      return "clock jump";
    case ServoFault::speed:
      return "speed";
    case ServoFault::stale_packet:
      return "stale packet";
    case ServoFault::peak:
      return "peak";
    case ServoFault::budget:
      return "budget";
    case ServoFault::warm_motors:
      return "warm motors";
  }
  return "";
}

void ServoFaults::set(ServoFault fault, bool is_on) noexcept {
  const auto place = static_cast<std::size_t>(fault);
  const std::uint32_t bit = 1U << place;
  counts_[place] += is_on && (on_ & bit) == 0 ? 1 : 0;
  on_ = is_on ? on_ | bit : on_ & ~bit;
}

std::uint32_t ServoFaults::count(ServoFault fault) const noexcept {
  return counts_[static_cast<std::size_t>(fault)];
}

bool ServoFaults::is_on(ServoFault fault) const noexcept {
  return (on_ >> static_cast<std::size_t>(fault) & 1U) != 0;
}

SafetyLimits limits_of_motors(float nominal_peak, float nominal_continuous) {
  check_positive("the peak", nominal_peak);
  check_positive("the continuous", nominal_continuous);
  const float peak = std::min(kUsedPeak * nominal_peak, kLargestPeak);
  return {.peak = peak, .continuous = std::min(nominal_continuous, peak)};
}

void Engagement::stop() noexcept {
  quiet_ticks_ = 0;
  gain_ = 0;
}

Eigen::Vector3f Engagement::apply(const Eigen::Vector3f& force, const Eigen::Vector3f& velocity,
                                  float tick) noexcept {
  if (quiet_ticks_ < kQuietTicks) {
    quiet_ticks_ = force.norm() < kQuietForce ? quiet_ticks_ + 1 : 0;
    return Eigen::Vector3f::Zero();
  }
  gain_ = std::min(1.0F, gain_ + tick / kRampTime);
  // the damping comes and goes without a step
  return gain_ * force - 4 * gain_ * (1 - gain_) * kDamping * velocity;
}

float StallWatchdog::gain(float age, float period, float tick) noexcept {
  const float begin = std::clamp(3 * period, kEarliestFade, kLatestFade);
  const float wanted = std::clamp((kEnd - age) / (kEnd - begin), 0.0F, 1.0F);
  gain_ = std::min(wanted, gain_ + tick / kReturnTime);
  return gain_;
}

float ForceBudget::clamp(const SafetyLimits& limits) const noexcept {
  const float used = std::sqrt(mean_square_) / limits.continuous;
  const float share = std::clamp((used - kBegins) / (1 - kBegins), 0.0F, 1.0F);
  return limits.peak + share * (limits.continuous - limits.peak);
}

void ForceBudget::add(float commanded, float tick) noexcept {
  mean_square_ += std::min(1.0F, tick / kTime) * (commanded * commanded - mean_square_);
}

Eigen::Vector3f SafetyChain::apply(const Eigen::Vector3f& computed,
                                   const SafetyInput& input) noexcept {
  const bool is_finite = computed.allFinite();
  const bool is_fast = !(input.velocity.norm() <= kLargestSpeed);
  faults_.set(ServoFault::bad_force, !is_finite);
  faults_.set(ServoFault::speed, is_fast);
  const float fresh = watchdog_.gain(input.packet_age, input.packet_period, input.tick);
  faults_.set(ServoFault::stale_packet, input.packet_age >= StallWatchdog::kEnd);
  faults_.set(ServoFault::warm_motors, input.is_warm);

  SafetyLimits limits = limits_;
  if (input.is_warm) {
    limits.peak /= 2;
    limits.continuous /= 2;
  }
  const float clamp = budget_.clamp(limits);
  faults_.set(ServoFault::budget, clamp < limits.peak);

  Eigen::Vector3f wanted = Eigen::Vector3f::Zero();
  if (!is_finite || is_fast || !input.is_ready || input.packet_age >= StallWatchdog::kEnd) {
    engagement_.stop();
    faults_.set(ServoFault::peak, false);
  } else {
    wanted = fresh * engagement_.apply(computed, input.velocity, input.tick);
    faults_.set(ServoFault::peak, wanted.norm() > limits.peak);
    wanted = clamped(wanted, clamp);
  }
  commanded_ += clamped(wanted - commanded_, kSlew * std::min(input.tick, kSlewTick));
  budget_.add(commanded_.norm(), input.tick);
  return commanded_;
}

}  // namespace pbdsurg
