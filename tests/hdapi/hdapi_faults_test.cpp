// SPDX-License-Identifier: Apache-2.0
// The driver alone: whatever breaks is counted and named, force stays within clamp and slew, the
// other hand goes on. The callback has no safety chain and does not care what the driver says.
#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <HD/hd.h>

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/fault_cases.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/support/catch.h"

namespace rig {
namespace {

using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::ErrorStack;
using hdapi_emulator::Fault;
using hdapi_emulator::ForceRecord;
using testing::After;
using testing::check_bounds;
using testing::FaultCase;
using testing::size_at;

constexpr double kEarlyFault = 0.5;  // s, of the fault
constexpr double kEarlyEnd = 2;      // s, of the test

}  // namespace

TEST_CASE("hdapi faults: each of twelve has a case and a name", "[unit]") {
  std::set<Fault> kinds;
  std::set<std::string> names;
  for (const FaultCase& one : testing::fault_cases()) {
    kinds.insert(one.fault);
    names.insert(hdapi_emulator::name_of(one.fault));
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
  const FaultCase& one = testing::fault_cases()[index];
  EmulatorOptions options = testing::two_hands();
  options.error_stack = GENERATE(ErrorStack::global, ErrorStack::per_thread);
  INFO(hdapi_emulator::name_of(one.fault));
  Emulator emulator(options);
  testing::Wall left(emulator, 0), right(emulator, 1);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.inject({.fault = one.fault, .begin = kEarlyFault, .duration = one.duration});
  while (emulator.scheduler_time() < kEarlyEnd) {
    // soon after one another: a program would take a second
    session.poll();
    emulator.step(50);
  }

  const auto forces = emulator.forces(0);
  check_bounds(forces);
  check_bounds(emulator.forces(1));
  REQUIRE(size_at(forces, kEarlyFault - 0.001) > 1.5);
  // in a time in which the last of what is polled is noticed
  const double least = testing::least_between(forces, kEarlyFault, kEarlyFault + 0.3);
  const HdapiStatus status = session.device(0).status();
  // packets are no matter of the driver's
  switch (one.counted ? one.after : After::never_off) {
    case After::never_off:
      CHECK(least > 1.5);
      CHECK_FALSE(status.is_lost);
      break;
    case After::comes_back:
      // without a chain, force is off for as long as the fault is there
      CHECK(least < 1.5);
      CHECK((least == 0 || one.duration < 0.013));
      CHECK(size_at(forces, kEarlyEnd) > 1.5);
      CHECK_FALSE(status.is_lost);
      CHECK(session.device(0).state().is_connected);
      break;
    case After::stays_off:
      // the last that its motors were told; then it is left alone
      CHECK(forces.back().set.norm() == 0);
      CHECK(forces.back().applied.norm() == 0);
      CHECK(forces.back().time < kEarlyFault + 0.2);
      CHECK(status.is_lost);
      CHECK_FALSE(session.device(0).state().is_connected);
      CHECK(session.device(0).state().pedals == pbdsurg::Pedals{});
      break;
  }
  testing::check_counts(one, status.faults);
  if (!testing::is_of_both(one.fault)) {
    for (const ForceRecord& force : emulator.forces(1)) {
      REQUIRE((force.time < kEarlyFault || force.set.norm() > 1.5));
    }
  }
}

// Catches a fault that is forgotten before the callback of the next tick: a safety chain behind it
// would go on as if nothing had been.
TEST_CASE("hdapi faults: the callback sees a fault of one tick in the next", "[unit]") {
  // all of which are found after the callback of their tick
  const Fault fault = GENERATE(Fault::force_error, Fault::warm_motors, Fault::simulation_nan);
  INFO(hdapi_emulator::name_of(fault));
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  std::vector<bool> were_ready, were_warm;
  auto devices = testing::feel(left, right);
  devices[0].force = [&](const HdapiTick& tick) {
    were_ready.push_back(tick.is_ready);
    were_warm.push_back(tick.is_warm);
    return left.force(tick);
  };
  HdapiSession session(devices, emulator.clock());
  emulator.inject({.fault = fault, .begin = 0.0995, .duration = 0.001});
  emulator.step(200);
  std::vector<bool> expected(200, true);
  expected[100] = false;  // the 101st tick; the fault is of the 100th
  CHECK(were_ready == expected);
  expected.assign(200, false);
  expected[100] = fault == Fault::warm_motors;
  CHECK(were_warm == expected);
  const auto forces = emulator.forces(0);
  CHECK(forces[100].set.norm() < forces[98].set.norm() - 0.15);
  check_bounds(forces);
}

// Catches a device whose motors go on pushing, as no frame could be had to tell them, and a status
// that speaks of a force which they never got.
TEST_CASE("hdapi faults: a device without frames is told zero once it has one again", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.inject({.fault = Fault::wrong_handle, .begin = 0.0995, .duration = 0.5});
  emulator.step(500);
  const ForceRecord last = emulator.forces(0).back();
  REQUIRE(last.applied.norm() > 1.5);
  const HdapiStatus status = session.device(0).status();
  CHECK(status.is_lost);
  CHECK(status.commanded_force.cast<double>() == last.set);
  CHECK(status.velocity.norm() == 0);
  emulator.step(150);
  CHECK(emulator.forces(0).back().applied.norm() == 0);
  CHECK(session.device(0).status().commanded_force.norm() == 0);
  check_bounds(emulator.forces(0));
  const std::size_t count = emulator.forces(0).size();
  emulator.step(100);
  CHECK(emulator.forces(0).size() == count);
}

// Catches a start that is put down to the program: a scheduler may need a while until it ticks.
TEST_CASE("hdapi faults: the first tick comes when it comes", "[unit]") {
  Emulator emulator(testing::two_hands());
  emulator.inject({.fault = Fault::dropped_tick, .begin = 0, .duration = 0.3});
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(500);
  const HdapiStatus status = session.device(0).status();
  CHECK(status.tick_count > 100);
  for (const DeviceFault fault :
       {DeviceFault::clock_jump, DeviceFault::dropped_tick, DeviceFault::late_tick}) {
    CHECK(status.faults.of(fault) == 0);
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

// Catches a safety chain that is left where it was when the motors had their zero: one whose ticks
// come soon after one another, as after a hold-up, is slower than the driver, and tells of its
// force for ever.
TEST_CASE("hdapi faults: the callback of a lost device is called on", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  auto devices = testing::feel(left, right);
  float size = 2;  // N
  devices[0].force = [&](const HdapiTick& tick) {
    size = tick.is_ready ? 2 : std::max(size - 0.01f, 0.f);
    return Eigen::Vector3f(0, size, 0);
  };
  HdapiSession session(devices, emulator.clock());
  emulator.inject({.fault = Fault::unplugged, .begin = 0.1, .device = 0});
  emulator.step(150);
  CHECK(session.device(0).status().commanded_force.isZero(0));
  CHECK(size > 1);
  const std::size_t frames = emulator.forces(0).size();
  emulator.step(200);
  CHECK(size == 0);
  CHECK(emulator.forces(0).size() == frames);
}

// Catches a driver that cannot stop once something is lost.
TEST_CASE("hdapi faults: a session ends cleanly after its devices are lost", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    emulator.step(100);
    emulator.inject({.fault = Fault::unplugged, .begin = 0.1, .device = 0});
    emulator.inject({.fault = Fault::lost_communication, .begin = 0.1, .device = 1});
  }
  CHECK(emulator.open_device_count() == 0);
  CHECK(emulator.callback_count() == 0);
  CHECK(emulator.error_count() == 0);
  CHECK(emulator.forces(0).back().set.norm() == 0);
}

}  // namespace rig
