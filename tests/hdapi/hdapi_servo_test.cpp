// SPDX-License-Identifier: Apache-2.0
// The driver with the servo that it is for: after whatever breaks, the safety chain lets force in
// again, and nothing else does.
#include <algorithm>
#include <vector>

#include "pbdsurg/haptics/servo.h"

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/fault_cases.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/hdapi/wall_servo.h"
#include "tests/support/catch.h"

namespace rig {
namespace {

using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::ErrorStack;
using hdapi_emulator::Fault;
using hdapi_emulator::ForceRecord;
using pbdsurg::testing::Approx;
using testing::After;
using testing::FaultCase;
using testing::ServoRecord;
using testing::WallServo;

constexpr double kBegin = 2;      // s, of the fault, with both hands in the wall
constexpr double kLifted = 2.3;   // s, from here on the left hand leaves it
constexpr double kAway = 0.3;     // s, that it stays away, at least
constexpr double kEnd = 5;        // s, of the test
constexpr double kPressed = 1.4;  // N, less than what hands in the wall feel

/// Hands come from the air into the wall; the left one leaves it and comes again.
/// @param again  s, when it does
EmulatorOptions two_hands_that_move(double again) {
  EmulatorOptions options = testing::two_hands();
  for (hdapi_emulator::DeviceOptions& device : options.devices) {
    const bool is_left = device.serial_number == "L";
    device.position.y() = 0.005;
    device.hand = [hand = device.hand, is_left, again](double time) {
      hdapi_emulator::Hand now = hand(time);
      const auto passed = [time](double begin) { return std::clamp((time - begin) / 0.1, 0., 1.); };
      const double depth = passed(1.4) - (is_left ? passed(kLifted) - passed(again) : 0);
      now.target.y() = 0.005 - 0.015 * depth;
      return now;
    };
  }
  return options;
}

/// N, what the motors were told in a tick; the record begins with the first.
Eigen::Vector3f told(const std::vector<ForceRecord>& forces, std::size_t tick) {
  return forces[tick].set.cast<float>();
}

}  // namespace

// Catches two ramps where there should be one, two engagements in a chain, a fault that the safety
// chain is not told of, force that comes back while the hand is in the tissue, and one that the
// driver changes on its way.
TEST_CASE("hdapi servo: after each fault force comes back along one ramp of a second, or not",
          "[unit]") {
  const auto index = GENERATE(range(std::size_t{0}, hdapi_emulator::kFaultCount));
  const FaultCase& one = testing::fault_cases()[index];
  INFO(hdapi_emulator::name_of(one.fault));
  EmulatorOptions options = two_hands_that_move(std::max(kLifted, kBegin + one.duration) + kAway);
  options.error_stack = GENERATE(ErrorStack::global, ErrorStack::per_thread);
  Emulator emulator(options);
  WallServo left(emulator, 0), right(emulator, 1);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.inject({.fault = one.fault, .begin = kBegin, .duration = one.duration});
  while (emulator.scheduler_time() < kEnd) {
    session.poll();
    emulator.step(50);
  }

  const auto forces = emulator.forces(0);
  testing::check_bounds(forces);
  testing::check_bounds(emulator.forces(1));
  testing::check_counts(one, session.device(0).status().faults);
  REQUIRE(testing::size_at(forces, kBegin - 0.001) > kPressed);
  const pbdsurg::ServoFaults& of_servo = left.servo.chain().faults();
  const double lifted = testing::least_between(forces, kLifted - 0.01, kLifted);
  switch (one.after) {
    case After::never_off:
      CHECK(lifted > kPressed);
      CHECK(of_servo.count(pbdsurg::ServoFault::device_lost) == 0);
      break;
    case After::stays_off:
      CHECK(forces.back().time < kBegin + 0.2);
      CHECK(forces.back().applied.norm() == 0);
      break;
    case After::comes_back: {
      CHECK(of_servo.count(one.counted ? pbdsurg::ServoFault::device_lost
                                       : pbdsurg::ServoFault::stale_packet) >= 1);
      CHECK(lifted == 0);  // though the fault may be over, the hand is in the wall
      // the ramp, from the last tick without any force
      std::size_t begin = forces.size() - 1;
      while (left.records[begin].engaged > 0) {
        --begin;
      }
      REQUIRE(forces[begin].time > kBegin);
      const auto share = [&](std::size_t ticks) {
        const float computed = left.records[begin + ticks].computed.norm();
        REQUIRE(computed > kPressed);
        return told(forces, begin + ticks).norm() / computed;
      };
      for (const std::size_t tick : {600u, 700u, 800u, 900u}) {
        CHECK(share(tick) == Approx(1e-3 * static_cast<double>(tick)).margin(0.01));
      }
      for (std::size_t tick = 1001; tick < 1100; ++tick) {
        CHECK(share(tick) == Approx(1).epsilon(1e-5));
      }
    }
  }
  // what the chain commands the motors get, but where the driver knows better
  std::size_t same = 0;
  for (std::size_t tick = 0; tick < forces.size(); ++tick) {
    const ServoRecord& record = left.records[tick];
    const bool is_after_fault = forces[tick].time > kBegin + one.duration + 0.02;
    if (record.is_ready && (forces[tick].time < kBegin || is_after_fault)) {
      REQUIRE((told(forces, tick) - record.commanded).norm() < 1e-5f);
      REQUIRE((forces[tick].applied - forces[tick].set).norm() == 0);
      ++same;
    }
  }
  CHECK(same > 1900);
  if (!testing::is_of_both(one.fault)) {
    for (const ForceRecord& force : emulator.forces(1)) {
      REQUIRE((force.time < kBegin || force.set.norm() > kPressed));
    }
  }
}

// Catches errors of the force that the emulator makes by itself.
TEST_CASE("hdapi servo: a stylus that is dropped has no force until it rests", "[unit]") {
  EmulatorOptions options = two_hands_that_move(kLifted + kAway);
  options.devices[0].hand = [hand = options.devices[0].hand](double time) {
    hdapi_emulator::Hand now = hand(time);
    if (time > kBegin && time < kBegin + 0.05) {
      now.target.x() += 3 * (time - kBegin);  // m/s
      now.stiffness = 5000;
    }
    return now;
  };
  Emulator emulator(options);
  WallServo left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(5000);
  const auto forces = emulator.forces(0);
  testing::check_bounds(forces);
  CHECK(session.device(0).status().faults.of(DeviceFault::exceeded_velocity) > 0);
  REQUIRE(testing::size_at(forces, kBegin - 0.001) > kPressed);
  CHECK(testing::size_at(forces, kBegin + 0.2) == 0);
  CHECK(testing::size_at(forces, kEnd) > kPressed);
}

}  // namespace rig
