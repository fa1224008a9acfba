// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/hand.h"

#include <limits>

#include "tests/support/catch.h"

namespace cholecystectomy {

using pbdsurg::testing::Approx;

namespace {

const Reach kReach{{0, 0, 0.2F}, {0, 0, 0}, 0.1F};

}  // namespace

// Would catch a shaft that leaves its port, or a roll about another axis.
TEST_CASE("hand: the shaft goes through the port, however the tip moves and rolls", "[unit]") {
  const pbdsurg::VirtualClock clock;
  MouseHand hand("left", kReach, {0.01F, 0, 0}, clock);
  hand.move({0.02F, -0.03F, 0.01F});
  const Eigen::Isometry3f before = hand.state().pose;
  CHECK((before.translation() - Eigen::Vector3f(0.03F, -0.03F, 0.01F)).norm() < 1e-6F);
  hand.roll(0.7F);
  const Eigen::Isometry3f pose = hand.state().pose;
  const Eigen::Vector3f shaft = pose.linear().col(2);
  CHECK((shaft - (kReach.port - pose.translation()).normalized()).norm() < 1e-5F);
  const Eigen::Matrix3f turn = before.linear().transpose() * pose.linear();
  CHECK(std::abs(Eigen::AngleAxisf(turn).angle()) == Approx(0.7F).epsilon(1e-4));
}

// Would catch a tip that a mouse throws through the wall, or loses to a number that is none.
TEST_CASE("hand: the tip stays within reach", "[unit]") {
  const pbdsurg::VirtualClock clock;
  MouseHand hand("left", kReach, {0, 0, 0}, clock);
  hand.move({5, 0, 0});
  CHECK((hand.tip() - Eigen::Vector3f(0.1F, 0, 0)).norm() < 1e-6F);
  hand.move({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  CHECK(hand.tip().allFinite());
  hand.move({-0.05F, 0, 0});
  CHECK(hand.tip().x() == Approx(0.05F));
}

TEST_CASE("hand: a state has the time, the jaw and the pedals of its last change", "[unit]") {
  pbdsurg::VirtualClock clock;
  MouseHand hand("right", kReach, {0, 0, 0}, clock);
  clock.advance(3);
  hand.set_jaw(-2);
  hand.set_pedals({.coagulation = true});
  const pbdsurg::DeviceState state = hand.state();
  CHECK(state.time == 3);
  CHECK(state.jaw == 0);
  CHECK(state.pedals == pbdsurg::Pedals{false, true});
  CHECK(state.is_connected);
  hand.reset();
  CHECK(hand.state().jaw == 1);
}

// Would catch a left-handed trainee whose hook comes from the wrong side.
TEST_CASE("hand: two exchange their ports and begin anew", "[unit]") {
  const pbdsurg::VirtualClock clock;
  MouseHand one("grasper", kReach, {0.01F, 0, 0}, clock);
  MouseHand other("hook", {{0.1F, 0, 0.2F}, {0, 0, 0}, 0.1F}, {0.05F, 0, 0}, clock);
  const Eigen::Isometry3f of_one = one.state().pose, of_other = other.state().pose;
  one.move({0.01F, 0.01F, 0});
  one.set_jaw(0);
  other.set_pedals({.cut = true});
  one.exchange_places(other);
  CHECK(one.state().pose.isApprox(of_other));
  CHECK(other.state().pose.isApprox(of_one));
  CHECK(one.state().jaw == 1);
  CHECK(other.state().pedals == pbdsurg::Pedals{});
  CHECK(one.name() == "grasper");
}

// Would catch a hand that is there but is not heard of.
TEST_CASE("hand: a refresh tells the time and changes nothing else", "[unit]") {
  pbdsurg::VirtualClock clock;
  MouseHand hand("grasper", kReach, {0.01F, 0, 0}, clock);
  const Eigen::Isometry3f pose = hand.state().pose;
  clock.advance(2);
  CHECK(hand.state().time == 0);
  hand.refresh();
  CHECK(hand.state().time == 2);
  CHECK(hand.state().pose.isApprox(pose));
}

}  // namespace cholecystectomy
