// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/scripted_hand.h"

#include <limits>
#include <numbers>

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::Approx;

Eigen::Quaternionf turned(float angle) {
  return Eigen::Quaternionf(Eigen::AngleAxisf(angle, Vector3f::UnitX()));
}

}  // namespace

// Would catch a hand that jumps, turns the long way, has pedals early or late, counts time from the
// clock's start, or moves on after its last waypoint.
TEST_CASE("scripted hand: it passes through its waypoints in time", "[unit]") {
  constexpr float kQuarter = std::numbers::pi_v<float> / 2;
  VirtualClock clock;
  clock.advance(5);
  const auto hand = scripted_hand(
      "tour",
      {{.time = 1, .tip = {1, 0, 0}, .pedals = {.cut = true}},
       {.time = 3, .tip = {1, 4, 0}, .orientation = turned(kQuarter), .jaw = 0, .pedals = {}}},
      clock);
  CHECK(hand->name() == "tour");
  CHECK(hand->state().pose.translation() == Vector3f(1, 0, 0));
  CHECK(hand->state().pedals == Pedals{});
  clock.wait_until(6);
  CHECK(hand->state().pedals == Pedals{.cut = true});
  clock.wait_until(6.5);
  DeviceState state = hand->state();
  CHECK(state.time == 6.5);
  CHECK(state.pose.translation().isApprox(Vector3f(1, 1, 0), 1e-6F));
  CHECK(state.pose.linear().isApprox(turned(kQuarter / 4).toRotationMatrix(), 1e-5F));
  CHECK(state.jaw == Approx(0.75));
  clock.wait_until(8);
  CHECK(hand->state().pedals == Pedals{});
  clock.wait_until(100);
  state = hand->state();
  CHECK(state.is_connected);
  CHECK(state.pose.translation() == Vector3f(1, 4, 0));
  CHECK(state.jaw == 0);
}

// Would catch a waypoint that would make a hand jump, or a pose that is none.
TEST_CASE("scripted hand: bad waypoints are refused", "[unit]") {
  const VirtualClock clock;
  const auto make = [&](const std::vector<Waypoint>& waypoints) {
    static_cast<void>(scripted_hand("tour", waypoints, clock));
  };
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  testing::check_refused([&] { make({}); }, "tour has no waypoint");
  testing::check_refused([&] { make({{.time = 1}, {.time = 1}}); }, "waypoint 1 of tour: its time");
  testing::check_refused([&] { make({{.time = kNone}}); }, "waypoint 0");
  testing::check_refused([&] { make({{.tip = {0, kNone, 0}}}); }, "tip");
  testing::check_refused([&] { make({{.orientation = {0.5F, 0, 0, 0}}}); }, "has length 0.5");
  testing::check_refused([&] { make({{.jaw = 1.5F}}); }, "its jaw is 1.5");
  testing::check_refused([&] { make({{.jaw = kNone}}); }, "its jaw");
}

}  // namespace pbdsurg
