// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/servo.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/haptics/rig.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Case;
using testing::FakeTissue;
using testing::felt_stiffness;
using testing::guide;
using testing::kAbove;
using testing::kEngaged;
using testing::Plant;
using testing::plant_grid;
using testing::pushed;
using testing::Rig;
using testing::settles;
using testing::Steps;
using testing::steps_of;

constexpr double kLargestStep = 0.1;     // N/ms, computed, p99.9
constexpr double kLargestSlew = 0.2001;  // N/ms, commanded, with rounding

void check_grid(const FakeTissue& tissue, int period = 10) {
  for (const Case& one : plant_grid(0)) {
    const Rig rig = pushed(one, tissue, {}, period);
    CAPTURE(one.plant.mass, one.plant.damping, one.plant.has_hand, one.delay);
    CHECK(settles(rig));
    CHECK(rig.surplus <= 1e-4);
    CHECK(steps_of(rig.computed).p999 <= kLargestStep);
    CHECK(steps_of(rig.commanded).largest <= kLargestSlew);
  }
}

Rig in_the_air(FakeTissue tissue) {
  Rig rig = testing::in_the_air(std::move(tissue));
  REQUIRE(rig.servo.chain().engaged() == 1);
  return rig;
}

void check_steps(const Rig& rig) {
  CHECK(steps_of(rig.computed).p999 <= kLargestStep);
  CHECK(steps_of(rig.computed).largest <= kLargestSlew);  // so that the limit is no part of it
  CHECK(steps_of(rig.commanded).largest <= kLargestSlew);
}

}  // namespace

// A few seconds of computing each: 54 plants in 13 s of virtual time.
TEST_CASE("servo: hard walls settle on all plants, and make no energy", "[unit]") {
  check_grid(testing::hard_wall());
}

TEST_CASE("servo: tissue settles on all plants, however soft it is thought to be", "[unit]") {
  check_grid(testing::soft_wall(50, 50));
  check_grid(testing::soft_wall(100, 100));
  check_grid(testing::soft_wall(150, 150));
  check_grid(testing::soft_wall(100, 20));
  check_grid(testing::soft_wall(150, 30));
}

// Packets that go on saying 80 N/m of tissue of 300 N/m, with forces that say otherwise. Without
// learning, plants of 1 N s/m oscillate at 0.4 m/s.
TEST_CASE("servo: tissue that is stiffer than it is thought to be is soon known", "[unit]") {
  for (const Case& one : plant_grid(0.3)) {
    CAPTURE(one.plant.mass, one.plant.damping, one.plant.has_hand, one.delay);
    const Rig rig = pushed(one, testing::soft_wall(300, 80));
    CHECK(settles(rig));
    CHECK(felt_stiffness(rig) <= 1.05 * double{kStiffness});
  }

  float stiffness = 300;  // and forgotten, once the tool has left it
  Rig rig = pushed(
      {{.damping = 1, .position = {0, kAbove, 0}}, 10},
      [&](ContactPacket& packet, double time) { testing::soft_wall(stiffness, 80)(packet, time); });
  rig.push.y() = 0.02;
  rig.run(4);
  stiffness = 100;
  rig.push.y() = -0.5;
  rig.run(10);
  CHECK(felt_stiffness(rig) == Approx(100).epsilon(0.05));
}

TEST_CASE("servo: plants settle by packets at 30 and at 1000 Hz", "[unit]") {
  check_grid(testing::hard_wall(), 33);
  check_grid(testing::hard_wall(), 1);
  check_grid(testing::soft_wall(150, 150), 1);
}

// Would catch a grid that everything passes.
TEST_CASE("servo: the paper's force law does not settle, and makes energy", "[unit]") {
  int unsettled = 0;
  double surplus = 0;
  for (const Case& one : plant_grid(0)) {
    const Rig rig = pushed(one, testing::soft_wall(150, 150), {.mode = ServoMode::paper});
    unsettled += settles(rig) ? 0 : 1;
    surplus = std::max(surplus, rig.surplus);
  }
  CHECK(unsettled > 10);
  CHECK(surplus > 1e-3);
}

TEST_CASE("servo: springs are felt as stiff as they are", "[unit]") {
  const auto is_felt = [](float stiffness, const Case& one, const ServoOptions& options) {
    return std::abs(felt_stiffness(pushed(one, testing::soft_wall(stiffness, stiffness), options)) /
                        double{stiffness} -
                    1) < 0.05;
  };
  for (const Case& one : plant_grid(0)) {
    CAPTURE(one.plant.mass, one.plant.damping, one.plant.has_hand, one.delay);
    for (const float stiffness : {50.0F, 100.0F, 150.0F}) {
      CAPTURE(stiffness);
      CHECK(is_felt(stiffness, one, {}));
    }
  }
  for (const Case& one : plant_grid(0.3)) {
    CAPTURE(one.plant.mass, one.plant.damping, one.plant.has_hand, one.delay);
    for (const float stiffness : {200.0F, 300.0F}) {
      CAPTURE(stiffness);
      CHECK(is_felt(stiffness, one, {.is_firm = true}));
      CHECK_FALSE(is_felt(stiffness, one, {}));  // 180 N/m is all that others give
    }
  }
}

TEST_CASE("servo: free motion is free", "[unit]") {
  Rig rig = in_the_air([](ContactPacket& packet, double) {
    packet.plane_count = 1;
    packet.planes[0] = {.normal = {0, 1, 0}, .stiffness = 180};
    fit_to_force(packet, 180);
  });
  guide(rig, 5, [](double time) {
    return Eigen::Vector3d(0.03 * std::sin(7 * time), 0.012 + 0.01 * std::cos(7 * time), 0);
  });
  for (const Eigen::Vector3f& force : rig.commanded) {
    REQUIRE(force.norm() < 0.05F);
  }
}

TEST_CASE("servo: drag resists motion, and no more than is stable", "[unit]") {
  float drag = 0;
  const FakeTissue membrane = [&](ContactPacket& packet, double) { packet.drag = drag; };
  const auto resistance = [&] {
    Rig rig = in_the_air(membrane);
    guide(rig, 0.5, [](double time) { return Eigen::Vector3d(0.1 * time, kAbove, 0); });
    check_steps(rig);
    return -rig.commanded.back().x() / 0.1F;  // N s/m
  };
  CHECK(resistance() == Approx(0).margin(1e-3));
  drag = 1;
  CHECK(resistance() == Approx(1).epsilon(0.1));
  drag = 100;
  CHECK(resistance() == Approx(kLargestDrag).epsilon(0.1));
  check_grid([](ContactPacket& packet, double time) {
    testing::hard_wall()(packet, time);
    packet.drag = 100;
  });
}

TEST_CASE("servo: steps of force stay small over edges and facets", "[unit]") {
  const Rig rig = testing::over_facets(180);
  check_steps(rig);
  float most = 0;
  for (const Eigen::Vector3f& force : rig.computed) {
    most = std::max(most, force.norm());
  }
  CHECK(most > 0.5F);  // it did touch

  // what the paper's law does there
  const Rig paper = testing::over_facets(60, {.mode = ServoMode::paper});
  CHECK(steps_of(paper.computed).p999 > kLargestStep);
}

TEST_CASE("servo: four points are no stiffer than one", "[unit]") {
  const FakeTissue four = testing::four_points();
  check_grid(four);
  CHECK(felt_stiffness(pushed({{.position = {0, kAbove, 0}}, 10}, four)) ==
        Approx(kStiffness).epsilon(0.02));
}

TEST_CASE("servo: a thin sheet never pulls", "[unit]") {
  const Rig rig = testing::through_sheet();
  check_steps(rig);
  for (const Eigen::Vector3f& force : rig.commanded) {
    REQUIRE(force.y() >= -1e-6F);
  }
  CHECK(rig.commanded.back().norm() < 1e-3F);
}

TEST_CASE("servo: grasps close, slip, saturate, open and tear without a step", "[unit]") {
  struct Jaw {
    GraspState state = GraspState::open;
    Eigen::Vector3f anchor{0, 0, 0};
  } jaw;
  Rig rig = in_the_air([&](ContactPacket& packet, double) {
    packet.grasp = {.state = jaw.state,
                    .anchor = packet_vector(jaw.anchor),
                    .stiffness = 150,
                    .largest_force = 1.5F};
    packet.force = packet_vector(grasp_force(packet.grasp, pose_of(packet)));
  });
  const auto pull = [&](double reach) {
    const double from = rig.target.y();
    guide(rig, 0.4, [=](double time) {
      return Eigen::Vector3d(0, from + (reach - from) * std::min(1.0, time / 0.3), 0);
    });
  };
  const auto let_go = [&](GraspState state) {
    jaw.state = state;
    rig.run(0.12);  // packets are late by 10 to 20 ms
    CHECK(rig.commanded.back().norm() <= 0.01F);
    pull(kAbove);
  };
  const auto force = [&] { return rig.commanded.back().norm(); };

  jaw.state = GraspState::held;
  rig.run(0.2);
  pull(0.012);
  CHECK(force() > 0.5F);
  let_go(GraspState::open);

  jaw.state = GraspState::held;
  rig.run(0.2);
  pull(0.04);
  CHECK(force() == Approx(1.5F).epsilon(0.01));  // saturated
  jaw.anchor = {0, 0.015F, 0};                   // it slips
  rig.run(0.3);
  CHECK(force() > 0.5F);
  jaw.anchor.setZero();
  rig.run(0.3);
  let_go(GraspState::torn);
  check_steps(rig);
}

// Would catch tissue in the jaws that is felt as soft as what the tip met before had to be.
TEST_CASE("servo: what jaws hold is learnt anew", "[unit]") {
  ServoState state;
  double time = 0;
  std::uint64_t sequence = 0;
  ServoForce force;
  // the tip goes from a height to another, in tissue of a stiffness, N/m, whose rest is at y = 0
  const auto go = [&](float from, float to, float stiffness, GraspState grasp) {
    constexpr int kTicks = 600;
    for (int tick = 0; tick < kTicks; ++tick, time += 1e-3) {
      Eigen::Isometry3f tip = Eigen::Isometry3f::Identity();
      tip.translation().y() =
          from + (to - from) * std::min(1.0F, 2 * static_cast<float>(tick) / kTicks);
      ContactPacket packet;
      packet.sequence = sequence;
      if (tick % 10 == 0) {
        packet.sequence = ++sequence;
        packet.time = time;
        set_pose(packet, tip);
        packet.grasp.state = grasp;
        packet.force = {0, -stiffness * tip.translation().y(), 0};
        fit_to_force(packet, stiffness);
      }
      force = servo_tick(state, packet, {.time = time, .tip = tip});
    }
  };
  go(1e-3F, 1e-3F, 0, GraspState::open);
  go(1e-3F, 1e-3F, 0, GraspState::open);  // lets force in
  go(0, -5e-3F, 1000, GraspState::open);
  REQUIRE(force.computed.y() < 0.25F * 5);  // stiff tissue is felt softer
  go(-5e-3F, -5e-3F, 100, GraspState::held);
  go(-5e-3F, -12e-3F, 100, GraspState::held);
  CHECK(force.computed.y() == Approx(1.2).epsilon(0.05));
}

TEST_CASE("servo: force dies with the simulation, and comes back without a step", "[unit]") {
  Rig rig =
      pushed({{.has_hand = true, .position = {0, kAbove, 0}}, 10}, testing::hard_wall(), {}, 10, 2);
  REQUIRE(rig.commanded.back().norm() > 0.4F);
  rig.publishes = false;
  rig.run(0.15 + 0.02);  // one was under way
  CHECK(rig.commanded.back().norm() <= 0.01F);
  CHECK(rig.servo.chain().faults().count(ServoFault::stale_packet) == 1);
  rig.run(0.5);
  rig.publishes = true;
  rig.run(1);
  CHECK(rig.commanded.back().norm() == 0);  // deep in tissue nothing comes back
  rig.target = {0, kAbove, 0};
  rig.run(2);
  CHECK(rig.servo.chain().engaged() == 1);
  rig.target = {0, -6e-3, 0};
  rig.run(1);
  CHECK(rig.commanded.back().norm() > 0.4F);
  CHECK(rig.servo.chain().faults().count(ServoFault::stale_packet) == 1);
  check_steps(rig);

  // a short pause: faded in part, and back
  rig.publishes = false;
  rig.run(0.09);
  const float least = rig.commanded.back().norm();
  CHECK(least < 0.4F);
  rig.publishes = true;
  rig.run(0.5);
  CHECK(rig.commanded.back().norm() > 0.4F);
  CHECK(rig.servo.chain().faults().count(ServoFault::stale_packet) == 1);
  check_steps(rig);
}

TEST_CASE("servo: whatever happens, force stays in clamp and slew, and has a name", "[unit]") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  struct Trouble {
    ServoFault fault;
    std::function<void(ServoInput&)> input;
    std::function<void(ContactPacket&)> packet;
  };
  const std::vector<Trouble> troubles{
      {ServoFault::bad_packet, {}, [](ContactPacket& packet) { packet.planes[0].offset = kNan; }},
      {ServoFault::bad_packet, {}, [](ContactPacket& packet) { packet.plane_count = 1000; }},
      {ServoFault::bad_pose, [](ServoInput& input) { input.tip.translation().x() = kNan; }, {}},
      {ServoFault::bad_force,
       {},
       [](ContactPacket& packet) {
         packet.planes[0].offset = 3e38F;
         packet.planes[0].stiffness = 3e38F;
       }},
      {ServoFault::device_lost, [](ServoInput& input) { input.is_ready = false; }, {}},
      {ServoFault::clock_jump, [](ServoInput& input) { input.time -= 100; }, {}},
      {ServoFault::clock_jump,
       [](ServoInput& input) { input.time = std::numeric_limits<double>::quiet_NaN(); },
       {}},
      {ServoFault::speed, [](ServoInput& input) { input.tip.translation().y() += 0.5F; }, {}},
      {ServoFault::peak, {}, [](ContactPacket& packet) { packet.planes[0].offset = 1; }},
      {ServoFault::warm_motors, [](ServoInput& input) { input.is_warm = true; }, {}}};
  for (const Trouble& trouble : troubles) {
    CAPTURE(name_of(trouble.fault));
    bool is_on = false;
    Rig rig = in_the_air([&](ContactPacket& packet, double time) {
      testing::hard_wall()(packet, time);
      if (is_on && trouble.packet) {
        trouble.packet(packet);
      }
    });
    rig.target = {0, -6e-3, 0};
    rig.run(1);
    CHECK(rig.commanded.back().norm() > 0.3F);
    CHECK(rig.servo.chain().faults().count(trouble.fault) == 0);
    is_on = true;
    rig.spoil = trouble.input;
    rig.run(0.3);
    CHECK(rig.servo.chain().faults().count(trouble.fault) >= 1);
    is_on = false;
    rig.spoil = {};
    rig.run(0.3);
    rig.target = {0, 5e-3, 0};
    rig.run(2.5);
    rig.target = {0, -6e-3, 0};
    rig.run(1);
    CHECK(rig.commanded.back().norm() > 0.3F);  // it is there again
    CHECK_FALSE(rig.servo.chain().faults().is_on(trouble.fault));
    CHECK(steps_of(rig.commanded).largest <= kLargestSlew);
    for (const Eigen::Vector3f& force : rig.commanded) {
      REQUIRE(force.norm() <= SafetyLimits{}.peak + 1e-5F);
    }
  }
}

TEST_CASE("servo: levers and scales are felt, and bounded", "[unit]") {
  const Eigen::Vector3f port(0, 0, 0), handle(0.05F, 0.2F, 0.02F);
  const Eigen::Vector3f tip = -0.6F * handle;
  const Eigen::Matrix3f lever = lever_about_port(port, handle, tip);
  const float length = (tip - handle).norm();
  for (int axis = 0; axis < 3; ++axis) {  // against finite differences
    const auto tip_of = [&](float step) -> Eigen::Vector3f {
      const Eigen::Vector3f moved = handle + step * Eigen::Vector3f::Unit(axis);
      return moved + length * (port - moved).normalized();
    };
    CHECK((lever.col(axis) - (tip_of(1e-3F) - tip_of(-1e-3F)) / 2e-3F).norm() < 1e-3F);
  }
  CHECK_THROWS_AS(lever_about_port(port, port, tip), InvalidArgument);

  // force at the handle over a step of the handle
  const auto stiffness_at = [](const ServoOptions& options, const Eigen::Matrix3f& by) {
    ServoState state(options);
    ContactPacket packet;
    packet.sequence = 1;
    packet.plane_count = 1;
    packet.planes[0] = {.normal = {0, 1, 0}, .offset = 0.01F, .stiffness = 1000};
    ServoInput input;
    input.lever = by;
    Eigen::Vector3f first = Eigen::Vector3f::Zero(), second = first;
    for (int i = 0; i < 100; ++i) {
      input.time = i * 1e-3;
      first = servo_tick(state, packet, input).computed;
    }
    input.tip.translation() = options.motion_scale * by * Eigen::Vector3f(0, 1e-3F, 0);
    input.time += 1e-3;
    second = servo_tick(state, packet, input).computed;
    return (first - second).y() / 1e-3F;
  };
  const Eigen::Matrix3f one = Eigen::Matrix3f::Identity();
  CHECK(stiffness_at({}, one) == Approx(180).epsilon(0.01));
  CHECK(stiffness_at({.is_firm = true}, one) == Approx(300).epsilon(0.01));
  CHECK(stiffness_at({.is_firm = true, .device_stiffness = 100}, one) == Approx(100).epsilon(0.01));
  CHECK(stiffness_at({.motion_scale = 2, .force_scale = 3}, one) == Approx(180).epsilon(0.01));
  CHECK(stiffness_at({}, -2 * one) == Approx(180).epsilon(0.01));
  CHECK(stiffness_at({}, -0.5F * one) == Approx(180).epsilon(0.01));
  CHECK(stiffness_at({}, -0.25F * one) == Approx(kLeastStiffness).epsilon(0.01));
}

TEST_CASE("servo: options out of range are refused", "[unit]") {
  CHECK_THROWS_AS(ServoState({.motion_scale = 0}), InvalidArgument);
  CHECK_THROWS_AS(ServoState({.force_scale = -1}), InvalidArgument);
  CHECK_THROWS_AS(ServoState({.device_stiffness = std::numeric_limits<float>::infinity()}),
                  InvalidArgument);
  CHECK_THROWS_AS(ServoState({.limits = {.peak = 0}}), InvalidArgument);
}

TEST_CASE("servo: the same calls give the same bits", "[unit]") {
  const Case one{{.position = {0, kAbove, 0}}, 10};
  const Rig first = pushed(one, testing::soft_wall(150, 60));
  const Rig second = pushed(one, testing::soft_wall(150, 60));
  CHECK(first.computed == second.computed);
  CHECK(first.commanded == second.commanded);
}

}  // namespace pbdsurg
