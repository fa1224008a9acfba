// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/hdapi_device.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <HD/hd.h>

#include "pbdsurg/base/error.h"

#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/support/catch.h"

namespace rig {
namespace {

using hdapi_emulator::CalibrationNeed;
using hdapi_emulator::DeviceOptions;
using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::ErrorStack;
using hdapi_emulator::Fault;
using hdapi_emulator::Hand;
using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

constexpr double kUntilWhole = 0.05;  // s, from the start until the force of a wall is whole

/// Lets time pass as a program does that polls once a second.
void pass(Emulator& emulator, HdapiSession& session, double seconds) {
  for (double left = seconds; left > 0; left -= 1) {
    session.poll();
    emulator.step(static_cast<int>(1000 * std::min(left, 1.0)));
  }
}

}  // namespace

// Catches any other order of starting and stopping, and a callback of each device.
TEST_CASE("hdapi: starts and stops in HDAPI's order, and leaves nothing", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.error_stack = GENERATE(ErrorStack::global, ErrorStack::per_thread);
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  hdInitDevice("whose error nobody took");
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    CHECK(session.device_count() == 2);
    CHECK(emulator.is_running());
    emulator.step(100);
    CHECK(emulator.open_device_count() == 2);
    CHECK(emulator.callback_count() == 1);
  }
  CHECK(emulator.calls() == std::vector<std::string>{"hdInitDevice", "hdInitDevice", "hdInitDevice",
                                                     "hdScheduleAsynchronous", "hdStartScheduler",
                                                     "hdStopScheduler", "hdUnschedule",
                                                     "hdDisableDevice", "hdDisableDevice"});
  CHECK(emulator.open_device_count() == 0);
  CHECK(emulator.callback_count() == 0);
  CHECK(emulator.error_count() == 0);
  const HdapiSession again(testing::feel(left, right), emulator.clock());  // all is as at first
}

// Catches a stop that drops the hand: the last force, cut off.
TEST_CASE("hdapi: forces have gone to zero by steps when the scheduler stops", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    pass(emulator, session, kUntilWhole);
    REQUIRE(emulator.forces(0).back().set.norm() > 1.5);
  }
  for (const int device : {0, 1}) {
    const auto forces = emulator.forces(device);
    CHECK(forces.back().set.norm() == 0);
    for (std::size_t index = 1; index < forces.size(); ++index) {
      REQUIRE((forces[index].set - forces[index - 1].set).norm() <= 0.2001);
    }
  }
}

// Catches millimetres taken for metres, hands and buttons exchanged, and poses of the tick before.
TEST_CASE("hdapi: states are metres, of the newest tick", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].hand = [](double time) {
    return Hand{.target = {-0.05 + 0.1 * time, -0.01, 0},
                .gimbal_angles = {0.1, 0.2, 0.3},
                .stiffness = 5000,
                .damping = 20,
                .buttons = HD_DEVICE_BUTTON_1,
                .is_in_inkwell = true};
  };
  Emulator emulator(options);
  testing::Wall wall(emulator);
  std::vector<HdapiTick> ticks;
  auto devices = testing::feel(wall, wall);
  devices[0].force = [&](const HdapiTick& tick) {
    ticks.push_back(tick);
    return Eigen::Vector3f(0, 0, 0);
  };
  HdapiSession session(devices, emulator.clock());
  CHECK(session.device(0).name() == "Touch (left)");
  CHECK(session.device(0).limits().max_force == Approx(3.3));
  CHECK(session.device(0).limits().max_continuous_force == Approx(0.88));
  CHECK(session.device(0).limits().workspace.sizes().isApprox(Eigen::Vector3f(.16f, .12f, .07f)));
  emulator.step(500);
  const pbdsurg::DeviceState state = session.device(0).state();
  const float resolution = static_cast<float>(options.devices[0].resolution);
  CHECK((state.pose.translation() - emulator.position(0).cast<float>()).norm() < resolution);
  CHECK(state.time == Approx(emulator.scheduler_time()));
  CHECK(state.buttons == 1);
  CHECK(state.is_connected);
  CHECK(state.jaw == 1);
  CHECK(state.pedals == pbdsurg::Pedals{});
  CHECK((state.pose.linear().transpose() * state.pose.linear()).isIdentity(1e-6f));
  CHECK(session.device(1).state().buttons == 2);
  CHECK(session.device(1).state().pose.translation().x() == Approx(0.05).margin(1e-3));
  const HdapiStatus status = session.device(0).status();
  CHECK(status.is_in_inkwell);
  CHECK(status.gimbal_angles.isApprox(Eigen::Vector3f(0.1f, 0.2f, 0.3f)));
  CHECK(status.velocity.x() == Approx(0.1).margin(0.03));
  CHECK(status.tick_count == 500);
  REQUIRE(ticks.size() == 500);
  CHECK(ticks.back().time == state.time);
  CHECK(ticks.back().pose.matrix() == state.pose.matrix());
  CHECK(ticks.back().is_ready);
}

// Catches a force of the tick before, or one that the callback did not ask for.
TEST_CASE("hdapi: the force of a pose is commanded in its own tick", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  auto devices = testing::feel(left, right);
  Eigen::Vector3f asked = Eigen::Vector3f::Zero();
  devices[0].force = [&](const HdapiTick& tick) { return asked = left.force(tick); };
  HdapiSession session(devices, emulator.clock());
  pass(emulator, session, kUntilWhole);
  for (int tick = 0; tick < 50; ++tick) {
    emulator.step(1);
    REQUIRE(emulator.forces(0).back().set == asked.cast<double>());
    REQUIRE(emulator.forces(0).back().applied == asked.cast<double>());
  }
  CHECK(asked.y() > 1.5f);
  CHECK(session.device(0).status().commanded_force == asked);
}

// Catches a weak device that is driven like a strong one.
TEST_CASE("hdapi: force stays below 0.8 of what the device has", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].max_force = 1;
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  pass(emulator, session, kUntilWhole);
  CHECK(emulator.forces(0).back().set.norm() == Approx(0.8));
  CHECK(emulator.forces(1).back().set.norm() > 1.5);
}

// Catches a driver that takes the lack of a thermometer for a fault.
TEST_CASE("hdapi: a model that tells less has its force all the same", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].has_extras = false;
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  pass(emulator, session, kUntilWhole);
  CHECK(emulator.forces(0).back().set.norm() > 1.5);
  const HdapiStatus status = session.device(0).status();
  CHECK(status.faults.of(DeviceFault::bad_call) == 0);
  CHECK(status.motor_temperature == 0);
  CHECK(session.device(1).status().motor_temperature > 0);
}

// Catches force on a device whose positions are off, and one that never gets calibrated.
TEST_CASE("hdapi: no force before a device is calibrated", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].calibration = CalibrationNeed::inkwell;
  options.devices[1].calibration = CalibrationNeed::update;
  options.devices[0].hand = [hand = options.devices[0].hand](double time) {
    Hand now = hand(time);
    now.is_in_inkwell = time > 2.5;
    return now;
  };
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  CHECK(session.device(1).status().calibration == HdapiCalibration::done);
  pass(emulator, session, 2);
  CHECK(session.device(0).status().calibration == HdapiCalibration::needs_inkwell);
  CHECK(emulator.forces(0).back().set.norm() == 0);
  CHECK(emulator.forces(1).back().set.norm() > 1.5);  // the other hand's goes on
  pass(emulator, session, 2);
  CHECK(session.device(0).status().calibration == HdapiCalibration::done);
  pass(emulator, session, 1);
  CHECK(emulator.forces(0).back().set.norm() > 1.5);
  CHECK(session.device(0).state().pose.translation().x() == Approx(-0.05).margin(1e-3));
}

// Catches a look that one hand has to wait for while the other is looked at: it may take long.
TEST_CASE("hdapi: calibrations are looked at after the frames of all", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices[0].calibration = CalibrationNeed::inkwell;
  options.devices[0].hand = [hand = options.devices[0].hand](double time) {
    Hand now = hand(time);
    now.is_in_inkwell = time > 0.05;
    return now;
  };
  Emulator emulator(options);
  testing::Wall left(emulator);
  HHD left_handle = HD_INVALID_HANDLE;
  std::vector<HDenum> seen;  // of the left device, by the right one's callback
  auto devices = testing::feel(left, left);
  devices[1].force = [&](const HdapiTick&) {
    const HHD own = hdGetCurrentDevice();
    hdMakeCurrentDevice(left_handle);
    seen.push_back(hdCheckCalibration());
    hdMakeCurrentDevice(own);
    return Eigen::Vector3f(0, 0, 0);
  };
  HdapiSession session(devices, emulator.clock());
  left_handle = hdGetCurrentDevice() - 1;
  emulator.step(100);
  session.poll();
  emulator.step(2);
  REQUIRE(seen.size() == 102);
  CHECK(seen[100] == HD_CALIBRATION_NEEDS_UPDATE);  // the tick that looks
  CHECK(seen[101] == HD_CALIBRATION_OK);
}

// Catches devices in the wrong hands after somebody exchanged their plugs or names.
TEST_CASE("hdapi: devices that are swapped are exchanged by serial number", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  auto devices = testing::feel(left, right);
  std::swap(devices[0].name, devices[1].name);
  HdapiSession session(devices, emulator.clock());
  emulator.step(100);
  CHECK(session.device(0).limits().serial_number == "L");
  CHECK(session.device(0).state().buttons == 1);
  CHECK(session.device(0).state().pose.translation().x() < 0);
  CHECK(session.device(1).state().pose.translation().x() > 0);
  for (const int hand : {0, 1}) {
    CHECK(session.device(hand).status().faults.of(DeviceFault::swapped_devices) == 1);
    CHECK_FALSE(session.device(hand).status().is_lost);
  }
}

// Catches a device that stays open, or a start with half of the devices.
TEST_CASE("hdapi: a device that is not there is refused by name", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  auto devices = testing::feel(left, right);
  devices[1].name = "Third Device";
  CHECK_THROWS_WITH(HdapiSession(devices, emulator.clock()), ContainsSubstring("'Third Device'"));
  CHECK(emulator.open_device_count() == 0);
  CHECK(emulator.callback_count() == 0);
  devices[1].name = "Right Device";
  devices[1].serial_number = "X";
  CHECK_THROWS_WITH(HdapiSession(devices, emulator.clock()),
                    ContainsSubstring("'R'") && ContainsSubstring("'X'"));
  CHECK(emulator.open_device_count() == 0);
  CHECK_FALSE(emulator.is_running());
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  devices = testing::feel(left, right);
  devices.erase(devices.begin());
  CHECK_THROWS_AS(HdapiSession(devices, emulator.clock()), pbdsurg::BackendUnavailable);  // runs
  hdDisableDevice(device);
}

// Catches a second session that ends with the scheduler of the first: its hands would be dropped.
TEST_CASE("hdapi: a process has one session at a time", "[unit]") {
  EmulatorOptions options = testing::two_hands();
  options.devices.push_back({.name = "Third Device"});
  Emulator emulator(options);
  testing::Wall left(emulator), right(emulator);
  const std::vector<HdapiDeviceOptions> third = {{.label = "third", .name = "Third Device"}};
  {
    HdapiSession session(testing::feel(left, right), emulator.clock());
    emulator.step(100);
    CHECK_THROWS_AS(HdapiSession(third, emulator.clock()), pbdsurg::BackendUnavailable);
    CHECK(emulator.is_running());
    CHECK(emulator.open_device_count() == 2);
    emulator.step(1);
    CHECK(emulator.forces(0).size() == 101);
    CHECK(emulator.forces(0).back().set.norm() > 1.5);
  }
  HdapiSession session(third, emulator.clock());
  CHECK(session.device_count() == 1);
  CHECK_THROWS_WITH(session.device(1), ContainsSubstring("device 1 is not among the 1"));
  CHECK_THROWS_AS(session.device(-1), pbdsurg::InvalidArgument);
}

TEST_CASE("hdapi: options that contradict are refused", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall wall(emulator);
  CHECK_THROWS_AS(HdapiSession({}, emulator.clock()), pbdsurg::InvalidArgument);
  auto devices = testing::feel(wall, wall);
  devices[1].name = devices[0].name;
  CHECK_THROWS_AS(HdapiSession(devices, emulator.clock()), pbdsurg::InvalidArgument);
  devices = testing::feel(wall, wall);
  devices[1].serial_number = "L";
  CHECK_THROWS_AS(HdapiSession(devices, emulator.clock()), pbdsurg::InvalidArgument);
  CHECK(emulator.calls().empty());
}

// Catches a window that believes in a hand after its scheduler died.
TEST_CASE("hdapi: without ticks for a quarter of a second nobody is connected", "[unit]") {
  Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(100);
  CHECK(session.device(0).state().is_connected);
  hdStopScheduler();
  emulator.step(300);
  CHECK_FALSE(session.device(0).state().is_connected);
}

TEST_CASE("hdapi: a program can tell what it was linked with", "[unit]") {
  CHECK(std::string(hdapi_flavour()) == "emulator");
}

}  // namespace rig
