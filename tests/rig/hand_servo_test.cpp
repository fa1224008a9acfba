// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/hand_servo.h"

#include <cmath>
#include <limits>

#include "tests/support/catch.h"

namespace rig {
namespace {

using Eigen::Isometry3f;
using Eigen::Vector3f;
using pbdsurg::testing::Approx;

pbdsurg::MappedInstrument at_height(float height) {
  return {Isometry3f(Eigen::Translation3f(0, 0, height)), Eigen::Matrix3f::Identity()};
}

// Tissue of 100 N/m below z = 0.
pbdsurg::ContactPacket floor_under(float height, std::uint64_t sequence, double time) {
  pbdsurg::ContactPacket packet;
  packet.sequence = sequence;
  packet.time = time;
  packet.position = {0, 0, height};
  packet.force = {0, 0, 100 * std::max(0.0F, -height)};
  packet.planes[0] = {.normal = {0, 0, 1}, .stiffness = 100};
  packet.plane_count = 1;
  return packet;
}

struct Run {
  HandServo servo{{}};
  Vector3f force{0, 0, 0};
  std::uint64_t sequence = 0;
  float at = 0.01F;  // m
  double time = 0;   // s

  // The arm goes to a height of the scene in so many ticks.
  void go(float to, int ticks) {
    const float from = at;
    for (int tick = 1; tick <= ticks; ++tick, time += 1e-3) {
      at = from + (to - from) * static_cast<float>(tick) / static_cast<float>(ticks);
      const float height = at;
      if (tick % 10 == 1) {
        servo.packets.draft() = floor_under(height, ++sequence, time);
        servo.packets.publish();
      }
      force = servo.tick(time, at_height(height), true, false);
    }
  }
};

}  // namespace

// Would catch a force of another packet or pose than the tick's, and an account that is not kept.
TEST_CASE("hand servo: a tick, and what is told of it", "[unit]") {
  Run run;
  run.go(0.01F, 1500);  // lets force in
  CHECK(run.force.isZero(0));
  run.go(-0.005F, 500);
  run.go(-0.005F, 1000);
  CHECK(run.force.z() == Approx(0.5).epsilon(0.05));
  CHECK(std::hypot(run.force.x(), run.force.y()) < 0.01F);
  const ServoReport& report = run.servo.report();
  CHECK(report.force.commanded == run.force);
  CHECK(report.missed_count == 0);
  CHECK(report.tick_count == 3000);
  CHECK(report.packet_ages.worst() == Approx(9e-3));
}

// Would catch a count of late ticks as missed ones, or none of those that were.
TEST_CASE("hand servo: ticks that did not come are counted", "[unit]") {
  HandServo servo({});
  for (const double time : {0.0, 1e-3, 2.4e-3, 3e-3, 6e-3, 7e-3}) {
    static_cast<void>(servo.tick(time, at_height(0), true, false));
  }
  CHECK(servo.report().missed_count == 2);
}

// Would catch a wheel that turns the arm's own point instead of the instrument.
TEST_CASE("hand servo: the handle's wheel turns points beside the shaft", "[unit]") {
  const auto felt_with_roll = [&](float roll) {
    HandServo servo({});
    servo.set_roll(roll);
    pbdsurg::ContactPacket packet;
    packet.sequence = 1;
    packet.planes[0] = {
        .point = {0.01F, 0, 0}, .normal = {1, 0, 0}, .offset = 0.015F, .stiffness = 150};
    packet.plane_count = 1;  // a wall at x = 15 mm, of a point that is 10 mm beside the shaft
    servo.packets.draft() = packet;
    servo.packets.publish();
    for (int tick = 0; tick < 100; ++tick) {
      static_cast<void>(servo.tick(1e-3 * tick, at_height(0), true, false));
    }
    return servo.report().force.computed.x();
  };
  CHECK(felt_with_roll(0) == Approx(150 * 0.005).epsilon(0.01));
  CHECK(felt_with_roll(3.14159265F) == Approx(150 * 0.025).epsilon(0.01));
}

// Would catch a pose that is no number on its way to the motors.
TEST_CASE("hand servo: a pose that is no number is no force", "[unit]") {
  Run run;
  run.go(0.01F, 1500);
  run.go(-0.005F, 500);
  REQUIRE(run.force.norm() > 0.3F);
  const pbdsurg::MappedInstrument nowhere = at_height(std::numeric_limits<float>::quiet_NaN());
  Vector3f before = run.force;
  for (int tick = 0; tick < 100; ++tick) {
    const Vector3f force = run.servo.tick(2 + 1e-3 * tick, nowhere, true, false);
    REQUIRE(force.allFinite());
    CHECK((force - before).norm() <= 0.2001F);
    before = force;
  }
  CHECK(before.isZero(0));
}

}  // namespace rig
