// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/servo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

constexpr float kNominalTick = 1e-3F;                                      // s
constexpr float kVelocityTime = 1 / (2 * std::numbers::pi_v<float> * 25);  // s, of a pole at 25 Hz
constexpr float kPeriodShare = 0.2F;     // of the newest interval in the mean
constexpr double kLongestPeriod = 0.1;   // s: beyond, the simulation was stopped
constexpr float kSecantWay = 0.5e-3F;    // m: shorter, encoders and solvers are too rough
constexpr float kForgetTime = 1;         // s, out of contact
constexpr float kNoForce = 0.02F;        // N
constexpr float kNearestHandle = 0.01F;  // m
constexpr float kLeastFade = 0.2F;       // of the slew
constexpr float kDone = 1 - 1e-4F;       // of a fade, as ticks do not add up to the bit

void check_range(const char* name, float value, bool is_fine, const char* rule) {
  if (!is_fine || !std::isfinite(value)) {
    throw InvalidArgument(std::string(name) + " of a servo is " + std::to_string(value) +
                          "; it must be " + rule + " and finite");
  }
}

// Makes a model stiffer, with the same forces at its packet's pose.
void stiffen(ContactPacket& packet, float factor) {
  const Eigen::Isometry3f pose = pose_of(packet);
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    ContactPlane& plane = packet.planes[i];
    const float height = vector_of(plane.normal).dot(pose * vector_of(plane.point));
    plane.offset = height + (plane.offset - height) / (plane.offset > height ? factor : 1);
    plane.stiffness *= factor;
  }
  const Eigen::Vector3f point = pose * vector_of(packet.grasp.point);
  packet.grasp.anchor = packet_vector(point + (vector_of(packet.grasp.anchor) - point) / factor);
  packet.grasp.stiffness *= factor;
}

ServoOptions checked(const ServoOptions& options) {
  const auto positive = [](const char* name, float value) {
    check_range(name, value, value > 0, "positive");
  };
  positive("motion_scale", options.motion_scale);
  check_range("force_scale", options.force_scale, options.force_scale >= 0, "not negative");
  positive("device_stiffness", options.device_stiffness);
  positive("limits.peak", options.limits.peak);
  positive("limits.continuous", options.limits.continuous);
  return options;
}

}  // namespace

Eigen::Matrix3f lever_about_port(const Eigen::Vector3f& port, const Eigen::Vector3f& handle,
                                 const Eigen::Vector3f& tip) {
  const Eigen::Vector3f shaft = port - handle;
  const float outside = shaft.norm();
  if (!port.allFinite() || !tip.allFinite() || !(outside >= kNearestHandle) ||
      !std::isfinite(outside)) {
    throw InvalidArgument("a handle is " + std::to_string(outside) +
                          " m from its port; port, handle and tip must be finite, and that at "
                          "least 0.01 m");
  }
  const Eigen::Vector3f along = shaft / outside;
  const float inside = along.dot(tip - port);
  const Eigen::Matrix3f axial = along * along.transpose();
  return axial - inside / outside * (Eigen::Matrix3f::Identity() - axial);
}

ServoState::ServoState(const ServoOptions& options)
    : options_(checked(options)), chain_(options_.limits) {}

// s, since the last tick; the nominal one where the clock jumped
float ServoState::measure_tick(double time) noexcept {
  const double tick = has_time_ ? time - time_ : double{kNominalTick};
  const bool is_fine = tick >= 0 && tick <= double{kLongestTick};
  chain_.faults().set(ServoFault::clock_jump, !is_fine);
  if (std::isfinite(time)) {
    time_ = time;
    has_time_ = true;
  }
  return is_fine ? static_cast<float>(tick) : kNominalTick;
}

void ServoState::receive(const ContactPacket& packet) noexcept {
  if (packet.sequence == 0 || packet.sequence == sequence_) {
    return;
  }
  const bool is_fine = is_valid(packet);
  chain_.faults().set(ServoFault::bad_packet, !is_fine);
  const bool is_first = sequence_ == 0;
  sequence_ = packet.sequence;
  if (!is_fine) {
    return;
  }
  const double period = packet.time - packet_time_;
  if (!is_first && period > 0 && period < kLongestPeriod) {
    packet_period_ += kPeriodShare * (static_cast<float>(period) - packet_period_);
  }
  packet_time_ = packet.time;
  packet_age_ = 0;
  next_ = packet;
  has_next_ = true;
  learn_stiffness(packet);
  held_ = plane_force(packet, pose_of(packet));
  if (packet.grasp.state == GraspState::held) {
    held_ += grasp_force(packet.grasp, pose_of(packet));
  }
}

// Two secants in a row, as what tears or slips changes force once.
void ServoState::learn_stiffness(const ContactPacket& packet) noexcept {
  const Eigen::Vector3f position = vector_of(packet.position), force = vector_of(packet.force);
  const Eigen::Vector3f way = position - secant_position_;
  if (packet.grasp.state != learned_grasp_) {  // what jaws hold is not what a tip presses on
    learned_grasp_ = packet.grasp.state;
    learned_ = secant_ = 0;
  } else if (secant_force_.norm() < kNoForce) {  // secants begin in contact
    learned_ -= learned_ * packet_period_ / kForgetTime;
    secant_ = 0;
  } else if (way.norm() < kSecantWay) {
    return;
  } else {
    const float secant = (secant_force_ - force).dot(way) / way.squaredNorm();
    learned_ = std::max(learned_, std::min(secant, secant_));
    secant_ = secant;
  }
  secant_position_ = position;
  secant_force_ = force;
}

void ServoState::begin_fade(const ServoInput& input) noexcept {
  old_ = new_;
  new_ = next_;
  has_next_ = false;
  weight_ = 0;

  float largest = options_.is_firm ? kFirmStiffness : kStiffness;
  largest = std::min(largest, options_.device_stiffness);
  if (packet_period_ > kSlowPeriod) {
    largest = std::min(largest, kSlowStiffness);
  }
  float share = 1;
  const float scale = options_.force_scale * options_.motion_scale;
  const float assumed = largest_eigenvalue(summed_stiffness(new_));
  if (assumed > 0) {
    const float felt =
        largest_eigenvalue(scale * input.lever.transpose() * summed_stiffness(new_) * input.lever);
    // what is felt of the tissue's own stiffness, or of a model that is at least as stiff
    const float tissue = std::max(felt, felt * learned_ / assumed);
    const float stiffest = std::max(tissue, std::min(kLeastStiffness, largest));
    if (felt > 0) {
      stiffen(new_, stiffest / felt);
    }
    share = stiffest > largest ? largest / stiffest : 1;
  }
  for (ContactPlane& plane : new_.planes) {
    plane.stiffness *= share;
  }
  new_.grasp.stiffness *= share;
  new_.grasp.largest_force *= share;
  new_.drag = std::min(new_.drag, kLargestDrag);
  if (new_.grasp.state != GraspState::held) {  // the old spring goes on until it has faded out
    const GraspState state = new_.grasp.state;
    new_.grasp = old_.grasp;
    new_.grasp.state = state;
  }
}

// 1/s, of the grasp's gain
float ServoState::grasp_rate() const noexcept {
  switch (new_.grasp.state) {
    case GraspState::held:
      return 1 / kGraspTime;
    case GraspState::open:
      return -1 / kGraspTime;
    case GraspState::torn:
      return -1 / kTearTime;
  }
  return 0;
}

// N, at the tip
Eigen::Vector3f ServoState::evaluate(const ServoInput& input, float tick) noexcept {
  if (options_.mode == ServoMode::paper) {
    return held_;
  }
  if (has_next_ && weight_ >= kDone) {
    begin_fade(input);
  }
  grasp_gain_ = std::clamp(grasp_gain_ + tick * grasp_rate(), 0.0F, 1.0F);
  const auto force_of = [&](const ContactPacket& packet) -> Eigen::Vector3f {
    const Eigen::Vector3f force = plane_force(packet, input.tip) +
                                  grasp_gain_ * grasp_force(packet.grasp, input.tip) -
                                  packet.drag * velocity_;
    const float felt = felt_at(input, force).norm();
    return felt > kLargestForce ? Eigen::Vector3f(force * (kLargestForce / felt)) : force;
  };
  const Eigen::Vector3f before = force_of(old_);
  const Eigen::Vector3f change = force_of(new_) - before;
  // the fade has what motion leaves of the slew, and some in any case, so that it ends
  const float drift = felt_at(input, before + weight_ * change - at_tip_).norm();
  const float room = std::max(kFadeSlew * tick - drift, kLeastFade * kFadeSlew * tick);
  const float fade = std::max(felt_at(input, change).norm(), std::numeric_limits<float>::min());
  weight_ = std::min(1.0F, weight_ + std::min(tick / packet_period_, room / fade));
  at_tip_ = before + weight_ * change;
  return at_tip_;
}

// N, at the handle
Eigen::Vector3f ServoState::felt_at(const ServoInput& input,
                                    const Eigen::Vector3f& at_tip) const noexcept {
  return options_.force_scale * (input.lever.transpose() * at_tip);
}

ServoForce servo_tick(ServoState& state, const ContactPacket& packet,
                      const ServoInput& input) noexcept {
  const float tick = state.measure_tick(input.time);
  ServoInput used = input;
  const bool has_pose = input.tip.matrix().allFinite() && input.lever.allFinite();
  state.chain_.faults().set(ServoFault::bad_pose, !has_pose);
  state.chain_.faults().set(ServoFault::device_lost, !input.is_ready);
  if (!has_pose) {
    used.tip = state.tip_;
    used.lever.setIdentity();
  }
  // after a jump nobody knows how old things are
  const bool is_ready = input.is_ready && has_pose && !input.has_leapt &&
                        !state.chain_.faults().is_on(ServoFault::clock_jump);
  if (state.has_tip_) {
    state.velocity_ +=
        (used.tip.translation() - state.tip_.translation() - tick * state.velocity_) /
        (tick + kVelocityTime);
  }
  state.tip_ = used.tip;
  state.has_tip_ = state.has_tip_ || has_pose;

  state.packet_age_ += state.sequence_ == 0 ? 0 : tick;
  state.receive(packet);
  const Eigen::Vector3f at_tip = state.evaluate(used, std::min(tick, kNominalTick));
  ServoForce force;
  force.computed = state.felt_at(used, at_tip);
  force.commanded = state.chain_.apply(force.computed, {.tick = tick,
                                                        .packet_age = state.packet_age_,
                                                        .packet_period = state.packet_period_,
                                                        .velocity = state.velocity_,
                                                        .is_ready = is_ready,
                                                        .is_warm = input.is_warm});
  return force;
}

}  // namespace pbdsurg
