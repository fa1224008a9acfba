// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/hand.h"

#include <algorithm>
#include <utility>

namespace cholecystectomy {

MouseHand::MouseHand(std::string name, const Reach& reach, const Eigen::Vector3f& tip,
                     const pbdsurg::Clock& clock)
    : name_(std::move(name)), reach_(reach), clock_(clock), start_(tip), tip_(tip) {
  publish();
}

void MouseHand::move(const Eigen::Vector3f& way) {
  if (!way.allFinite()) {
    return;
  }
  const Eigen::Vector3f from_centre = tip_ + way - reach_.centre;
  const float distance = from_centre.norm();
  tip_ = reach_.centre + (distance > reach_.radius ? reach_.radius / distance : 1) * from_centre;
  publish();
}

void MouseHand::roll(float angle) {
  roll_ += angle;
  publish();
}

void MouseHand::set_jaw(float jaw) {
  jaw_ = std::clamp(jaw, 0.0F, 1.0F);
  publish();
}

void MouseHand::set_pedals(const pbdsurg::Pedals& pedals) {
  pedals_ = pedals;
  publish();
}

void MouseHand::reset() {
  tip_ = start_;
  roll_ = 0;
  jaw_ = 1;
  pedals_ = {};
  publish();
}

void MouseHand::exchange_places(MouseHand& other) {
  std::swap(reach_, other.reach_);
  std::swap(start_, other.start_);
  reset();
  other.reset();
}

pbdsurg::DeviceState MouseHand::state() noexcept {
  states_.take();
  return states_.value();
}

void MouseHand::publish() {
  pbdsurg::DeviceState& state = states_.draft();
  state = {};
  state.time = clock_.now();
  state.pose = Eigen::Translation3f(tip_) *
               Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), reach_.port - tip_) *
               Eigen::AngleAxisf(roll_, Eigen::Vector3f::UnitZ());
  state.jaw = jaw_;
  state.pedals = pedals_;
  states_.publish();
}

}  // namespace cholecystectomy
