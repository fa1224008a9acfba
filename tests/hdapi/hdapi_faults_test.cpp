// SPDX-License-Identifier: Apache-2.0
// Whatever breaks is counted and named, force stays within clamp and slew, the other hand goes on.
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <HD/hd.h>

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/support/catch.h"

namespace rig {
namespace {

using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::ErrorStack;
using hdapi_emulator::Fault;
using hdapi_emulator::FaultPlan;
using hdapi_emulator::ForceRecord;

enum class After { comes_back, stays_off, never_off };

/// What a fault of 0.1 s must do.
struct Expected {
  Fault fault;
  std::optional<DeviceFault> counted;  // by the driver; else by the servo
  After after;
  double duration = 0.1;  // s
};

constexpr double kBegin = 2;  // s, of the fault
constexpr double kEnd = 5;    // s, of the test

const std::vector<Expected>& all_faults() {
  static const std::vector<Expected> faults = {
      {Fault::lost_communication, DeviceFault::lost_communication, After::stays_off},
      {Fault::dropped_tick, DeviceFault::dropped_tick, After::never_off, 0.003},
      {Fault::late_tick, DeviceFault::late_tick, After::never_off, 0.001},
      {Fault::warm_motors, DeviceFault::warm_motors, After::comes_back},
      // long enough for as many updates as make it stuck, one a poll
      {Fault::stuck_calibration, DeviceFault::stuck_calibration, After::comes_back, 1},
      {Fault::wrong_handle, DeviceFault::wrong_handle, After::stays_off},
      {Fault::force_error, DeviceFault::force_error, After::comes_back},
      {Fault::unplugged, DeviceFault::device_failure, After::stays_off},
      {Fault::simulation_nan, DeviceFault::simulation_not_a_number, After::comes_back},
      {Fault::stale_packets, std::nullopt, After::comes_back, 0.5},
      {Fault::clock_jump, DeviceFault::clock_jump, After::comes_back},
      {Fault::swapped_devices, DeviceFault::swapped_devices, After::stays_off},
  };
  return faults;
}

double size_at(const std::vector<ForceRecord>& forces, double time) {
  double size = -1;
  for (const ForceRecord& force : forces) {
    if (force.time <= time) {
      size = force.set.norm();
    }
  }
  return size;
}

void check_bounds(const std::vector<ForceRecord>& forces) {
  for (std::size_t index = 1; index < forces.size(); ++index) {
    INFO("at " << forces[index].time << " s");
    REQUIRE(forces[index].set.allFinite());
    REQUIRE(forces[index].set.norm() <= 2.6001);
    REQUIRE((forces[index].set - forces[index - 1].set).norm() <= 0.2001);
  }
}

}  // namespace

TEST_CASE("hdapi faults: each of twelve has a case and a name", "[unit]") {
  std::set<Fault> kinds;
  std::set<std::string> names;
  for (const Expected& expected : all_faults()) {
    kinds.insert(expected.fault);
    names.insert(hdapi_emulator::name_of(expected.fault));
  }
  CHECK(kinds.size() == hdapi_emulator::kFaultCount);
  CHECK(names.size() == hdapi_emulator::kFaultCount);
  std::set<std::string> of_driver;
  for (std::size_t index = 0; index < kDeviceFaultCount; ++index) {
    of_driver.insert(name_of(static_cast<DeviceFault>(index)));
  }
  CHECK(of_driver.size() == kDeviceFaultCount);
  CHECK(of_driver.count("") == 0);
}

// Catches faults that nobody counts, forces that jump, forces that stay, and a hand that suffers
// for the other.
TEST_CASE("hdapi faults: counted, within clamp and slew, and over or off as they must be",
          "[unit]") {
  const auto index = GENERATE(range(std::size_t{0}, hdapi_emulator::kFaultCount));
  const Expected& expected = all_faults()[index];
  EmulatorOptions options = testing::two_hands();
  options.error_stack = GENERATE(ErrorStack::global, ErrorStack::per_thread);
  INFO(hdapi_emulator::name_of(expected.fault));
  Emulator emulator(options);
  testing::Wall left(emulator, 0), right(emulator, 1);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.inject({.fault = expected.fault, .begin = kBegin, .duration = expected.duration});
  while (emulator.scheduler_time() < kEnd) {
    // soon after one another: a program would take a second
    session.poll();
    emulator.step(50);
  }

  const auto forces = emulator.forces(0);
  check_bounds(forces);
  check_bounds(emulator.forces(1));
  REQUIRE(size_at(forces, kBegin - 0.001) > 1.5);
  // the least force in the tenth of a second in which the last of what is polled is noticed
  double least = 10;
  for (const ForceRecord& force : forces) {
    if (force.time > kBegin && force.time < kBegin + 0.3) {
      least = std::min(least, force.set.norm());
    }
  }
  const HdapiStatus status = session.device(0).status();
  switch (expected.after) {
    case After::never_off:
      CHECK(least > 1.5);
      CHECK_FALSE(status.is_lost);
      break;
    case After::comes_back:
      CHECK(least <= 0.01);
      CHECK(size_at(forces, kEnd) > 1.5);
      CHECK_FALSE(status.is_lost);
      CHECK(session.device(0).state().is_connected);
      break;
    case After::stays_off:
      if (expected.fault != Fault::wrong_handle) {  // of which no frame can be had
        CHECK(least == 0);
      }
      CHECK(forces.back().time < kBegin + 0.2);  // it is left alone
      CHECK(status.is_lost);
      CHECK_FALSE(session.device(0).state().is_connected);
      CHECK(session.device(0).state().pedals == pbdsurg::Pedals{});
      break;
  }
  if (expected.counted) {
    CHECK(status.faults.of(*expected.counted) >= 1);
    if (is_fatal(*expected.counted)) {
      CHECK(status.faults.of(*expected.counted) == 1);  // though it lasts
    }
  } else {
    CHECK(left.stale_tick_count() > 0);
  }
  // nothing else happened
  for (std::size_t other = 0; other < kDeviceFaultCount; ++other) {
    const DeviceFault fault = static_cast<DeviceFault>(other);
    if (fault != expected.counted) {
      INFO(name_of(fault));
      CHECK(status.faults.of(fault) == 0);
    }
  }
  const bool is_of_both =
      expected.fault == Fault::clock_jump || expected.fault == Fault::swapped_devices;
  if (!is_of_both) {
    for (const ForceRecord& force : emulator.forces(1)) {
      REQUIRE((force.time < kBegin || force.set.norm() > 1.5));
    }
  }
}

TEST_CASE("hdapi faults: ticks that are missing are counted one by one", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.inject({.fault = Fault::dropped_tick, .begin = 0.0995, .duration = 0.003});
  emulator.inject({.fault = Fault::dropped_tick, .begin = 0.1995, .duration = 0.001});
  emulator.inject({.fault = Fault::late_tick, .begin = 0.2995, .duration = 0.001});
  emulator.step(500);
  CHECK(session.device(0).status().faults.of(DeviceFault::dropped_tick) == 4);
  CHECK(session.device(0).status().faults.of(DeviceFault::late_tick) == 1);
  CHECK(session.device(0).status().tick_count == 496);
}

// Catches a driver that asks the current device, which is then the other hand's.
TEST_CASE("hdapi faults: with a wrong handle the other hand's pose is not taken", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(100);
  emulator.inject({.fault = Fault::wrong_handle, .begin = 0.1, .device = 1});
  emulator.step(100);
  CHECK(session.device(1).state().pose.translation().x() > 0.04f);
  CHECK(session.device(1).state().buttons == 2);
  CHECK(session.device(0).state().pose.translation().x() < -0.04f);
  CHECK_FALSE(session.device(0).status().is_lost);
}

// Catches an error that is put down to the device which is looked at when it is found, and a frame
// that is taken for one that did not begin, because of an error that lay there before.
TEST_CASE("hdapi faults: an error is the device's that it names, and costs no frame", "[unit]") {
  const int named = GENERATE(0, 1);
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  HHD handle = hdGetCurrentDevice() - 1 + named;  // the right hand's is current: it came last
  hdScheduleAsynchronous(
      [](void* data) -> HDCallbackCode {
        hdEndFrame(*static_cast<HHD*>(data));  // without a beginning
        return HD_CALLBACK_DONE;
      },
      &handle, HD_MIN_SCHEDULER_PRIORITY);
  emulator.step(10);
  for (const int hand : {0, 1}) {
    CHECK(session.device(hand).status().faults.of(DeviceFault::bad_call) ==
          (hand == named ? 1 : 0));
    CHECK(emulator.forces(hand).size() == 10);
  }
}

// Catches errors of the force that the emulator makes by itself.
TEST_CASE("hdapi faults: a stylus that is dropped has no force until it rests", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].hand = [hand = options.devices[0].hand](double time) {
    hdapi_emulator::Hand now = hand(time);
    if (time > 2 && time < 2.05) {
      now.target.x() += 3 * (time - 2);  // m/s
      now.stiffness = 5000;
    }
    return now;
  };
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(4000);
  check_bounds(emulator.forces(0));
  CHECK(session.device(0).status().faults.of(DeviceFault::exceeded_velocity) > 0);
  CHECK(size_at(emulator.forces(0), 2.2) < 0.1);
  CHECK(size_at(emulator.forces(0), 4) > 1.5);
}

// Catches a driver that cannot stop once something is lost.
TEST_CASE("hdapi faults: a session ends cleanly after its devices are lost", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    emulator.step(1500);
    emulator.inject({.fault = Fault::unplugged, .begin = 1.5, .device = 0});
    emulator.inject({.fault = Fault::lost_communication, .begin = 1.5, .device = 1});
  }
  CHECK(emulator.open_device_count() == 0);
  CHECK(emulator.callback_count() == 0);
  CHECK(emulator.error_count() == 0);
  CHECK(emulator.forces(0).back().set.norm() == 0);
}

}  // namespace rig
