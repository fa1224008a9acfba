// SPDX-License-Identifier: Apache-2.0
// The scheduler's real thread at 1000 Hz: for the thread sanitizer. Times are no matter.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

#include <HD/hd.h>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/servo.h"

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/hdapi/wall_servo.h"
#include "tests/support/catch.h"

namespace rig {
namespace {

using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::ErrorStack;
using hdapi_emulator::Fault;

}  // namespace

// Catches data that the scheduler's thread and the program's share without order.
TEST_CASE("hdapi threads: a real scheduler runs beside a program that polls and looks", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.has_real_time = true;
  options.error_stack = GENERATE(ErrorStack::global, ErrorStack::per_thread);
  Emulator emulator(options);
  testing::Wall left(emulator, 0), right(emulator, 1);
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    emulator.inject({.fault = Fault::warm_motors, .begin = 0.05, .duration = 0.02});
    emulator.inject({.fault = Fault::lost_communication, .begin = 0.1, .device = 1});
    double time = 0;
    while (emulator.scheduler_time() < 0.4) {
      session.poll();
      for (const int hand : {0, 1}) {
        const pbdsurg::DeviceState state = session.device(hand).state();
        REQUIRE(state.pose.matrix().allFinite());
        REQUIRE(session.device(hand).status().commanded_force.allFinite());
        if (hand == 0) {
          REQUIRE(state.time >= time);
          time = state.time;
        }
      }
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    CHECK(session.device(0).status().tick_count > 10);
    CHECK_FALSE(session.device(0).status().is_lost);
    CHECK(session.device(1).status().is_lost);
  }
  CHECK_FALSE(emulator.is_running());
  CHECK(emulator.callback_count() == 0);
  CHECK(emulator.open_device_count() == 0);
}

// Catches a way from the simulation to the servo, or back, on which the two share data without
// order.
TEST_CASE("hdapi threads: servos in a real scheduler feel what a simulation publishes", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.has_real_time = true;
  for (auto& device : options.devices) {
    device.hand = [at = device.position](double time) {  // from the air into the wall
      return hdapi_emulator::Hand{
          .target = {at.x(), time < 0.3 ? 0.002 : -0.005, 0}, .stiffness = 1000, .damping = 10};
    };
    device.position.y() = 0.002;
  }
  Emulator emulator(options);
  struct Hand {
    pbdsurg::ServoState servo;
    pbdsurg::Mailbox<pbdsurg::ContactPacket> packets;
    float most = 0;  // N
    Eigen::Vector3f force(const HdapiTick& tick) {
      packets.take();
      const pbdsurg::ServoForce force = testing::servo_force(servo, packets.value(), tick);
      most = std::max(most, force.computed.norm());
      return force.commanded;
    }
  } left, right;
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    for (std::uint64_t step = 1; emulator.scheduler_time() < 0.8; ++step) {
      int hand = 0;
      for (Hand* each : {&left, &right}) {
        each->packets.draft() =
            testing::wall_packet(step, emulator.clock().now(), session.device(hand).state().pose);
        each->packets.publish();
        ++hand;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  CHECK(left.most > 0.1f);
  CHECK(right.most > 0.1f);
  CHECK(emulator.forces(0).back().set.norm() == 0);
  CHECK(emulator.forces(1).back().set.norm() == 0);
}

// Catches a synchronous callback that nobody runs, or that nobody waits for.
TEST_CASE("hdapi threads: a synchronous callback of another thread has run on return", "[unit]") {
  EmulatorOptions options;
  options.has_real_time = true;
  Emulator emulator(options);
  hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  for (int round = 0; round < 20; ++round) {
    std::thread::id runner;
    hdScheduleSynchronous(
        [](void* data) -> HDCallbackCode {
          *static_cast<std::thread::id*>(data) = std::this_thread::get_id();
          return HD_CALLBACK_DONE;
        },
        &runner, HD_DEFAULT_SCHEDULER_PRIORITY);
    REQUIRE(runner != std::thread::id{});
    REQUIRE(runner != std::this_thread::get_id());
  }
  hdStopScheduler();
}

}  // namespace rig
