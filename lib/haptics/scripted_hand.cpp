// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/scripted_hand.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lib/haptics/check_device.h"

namespace pbdsurg {
namespace {

class ScriptedHand final : public Device {
 public:
  ScriptedHand(std::string name, std::vector<Waypoint> waypoints, const Clock& clock)
      : name_(std::move(name)),
        waypoints_(std::move(waypoints)),
        clock_(clock),
        begin_(clock.now()) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] DeviceState state() noexcept override {
    DeviceState state;
    state.time = clock_.now();
    const double time = state.time - begin_;
    while (passed_ + 1 < waypoints_.size() && waypoints_[passed_ + 1].time <= time) {
      ++passed_;
    }
    const Waypoint& from = waypoints_[passed_];
    const Waypoint& to = waypoints_[std::min(passed_ + 1, waypoints_.size() - 1)];
    const auto part = static_cast<float>(
        to.time > from.time ? std::clamp((time - from.time) / (to.time - from.time), 0.0, 1.0) : 0);
    state.pose = Eigen::Translation3f(from.tip + part * (to.tip - from.tip)) *
                 from.orientation.slerp(part, to.orientation);
    state.jaw = from.jaw + part * (to.jaw - from.jaw);
    state.pedals = time >= from.time ? from.pedals : Pedals{};
    return state;
  }

 private:
  std::string name_;
  std::vector<Waypoint> waypoints_;
  const Clock& clock_;
  double begin_;  // s
  std::size_t passed_ =
      0;  // the last waypoint whose time has come, or the first; clocks never go back
};

}  // namespace

std::unique_ptr<Device> scripted_hand(std::string name, std::vector<Waypoint> waypoints,
                                      const Clock& clock) {
  if (waypoints.empty()) {
    throw InvalidArgument("the scripted hand " + name + " has no waypoint; it must have one");
  }
  const auto refuse = [&](std::size_t index, const std::string& reason) {
    throw InvalidArgument("waypoint " + std::to_string(index) + " of " + name + ": " + reason);
  };
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Waypoint& waypoint = waypoints[i];
    if (!std::isfinite(waypoint.time) || (i > 0 && !(waypoint.time > waypoints[i - 1].time))) {
      refuse(i, "its time is " + std::to_string(waypoint.time) +
                    " s; it must be finite and after that of the waypoint before");
    }
    if (!waypoint.tip.allFinite()) {
      refuse(i, "its tip is not finite; it must be");
    }
    const float length = waypoint.orientation.norm();
    if (!(std::abs(length - 1) <= kAxisTolerance)) {
      refuse(i, "its orientation has length " + std::to_string(length) + "; it must have 1");
    }
    if (!(waypoint.jaw >= 0 && waypoint.jaw <= 1)) {
      refuse(i, "its jaw is " + std::to_string(waypoint.jaw) + "; it must be 0 to 1");
    }
  }
  return std::make_unique<ScriptedHand>(std::move(name), std::move(waypoints), clock);
}

}  // namespace pbdsurg
