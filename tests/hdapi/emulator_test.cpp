// SPDX-License-Identifier: Apache-2.0
// HDAPI's rules, as far as drivers rely on them: a test for each.
#include "apps/hdapi_emulator/emulator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <HD/hd.h>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace hdapi_emulator {
namespace {

using pbdsurg::testing::Approx;

/// Runs a function in the scheduler's next tick.
void in_tick(const std::function<void()>& function) {
  auto copy = function;
  hdScheduleSynchronous(
      [](void* data) -> HDCallbackCode {
        (*static_cast<std::function<void()>*>(data))();
        return HD_CALLBACK_DONE;
      },
      &copy, HD_DEFAULT_SCHEDULER_PRIORITY);
}

/// Errors that wait, the newest first.
std::vector<HDerror> take_errors() {
  std::vector<HDerror> errors;
  for (HDErrorInfo info = hdGetError(); HD_DEVICE_ERROR(info); info = hdGetError()) {
    errors.push_back(info.errorCode);
  }
  return errors;
}

using Codes = std::vector<HDerror>;

Eigen::Vector3d get(HDenum parameter) {
  Eigen::Vector3d values;
  hdGetDoublev(parameter, values.data());
  return values;
}

void set_force(const Eigen::Vector3d& force) {
  hdSetDoublev(HD_CURRENT_FORCE, force.data());
}

/// Two devices, of which the first is held by a hand that moves.
EmulatorOptions two_devices() {
  EmulatorOptions options;
  options.devices = {DeviceOptions{.name = "Left", .serial_number = "L"},
                     DeviceOptions{.name = "Right", .serial_number = "R"}};
  options.devices[0].hand = [](double time) {
    return Hand{.target = {0.1 * time, 0, 0}, .stiffness = 2000, .damping = 10, .buttons = 2};
  };
  return options;
}

}  // namespace

TEST_CASE("emulator: a device opens by its name, once, and is current", "[unit]") {
  const Emulator emulator(two_devices());
  CHECK(hdInitDevice("Middle") == HD_INVALID_HANDLE);
  CHECK(take_errors() == Codes{HD_DEVICE_FAULT});
  const HHD left = hdInitDevice(HD_DEFAULT_DEVICE);
  CHECK(hdGetCurrentDevice() == left);
  CHECK(std::string(hdGetString(HD_DEVICE_SERIAL_NUMBER)) == "L");
  const HHD right = hdInitDevice("Right");
  CHECK(hdGetCurrentDevice() == right);
  CHECK(take_errors().empty());
  CHECK(hdInitDevice("Right") == HD_INVALID_HANDLE);
  CHECK(take_errors() == Codes{HD_DEVICE_ALREADY_INITIATED});
  CHECK(emulator.open_device_count() == 2);
  hdDisableDevice(left);
  hdDisableDevice(right);
  CHECK(emulator.open_device_count() == 0);
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: all calls are about the current device", "[unit]") {
  const Emulator emulator(two_devices());
  const HHD left = hdInitDevice("Left");
  hdInitDevice("Right");
  CHECK(std::string(hdGetString(HD_DEVICE_SERIAL_NUMBER)) == "R");
  hdMakeCurrentDevice(left);
  CHECK(std::string(hdGetString(HD_DEVICE_SERIAL_NUMBER)) == "L");
  CHECK(take_errors().empty());
  hdMakeCurrentDevice(77);
  CHECK(take_errors() == Codes{HD_BAD_HANDLE});
  CHECK(hdGetCurrentDevice() == left);
  hdBeginFrame(HD_INVALID_HANDLE);
  CHECK(take_errors() == Codes{HD_BAD_HANDLE});
}

TEST_CASE("emulator: a frame holds the state still and makes its device current", "[unit]") {
  Emulator emulator(two_devices());
  const HHD left = hdInitDevice("Left");
  hdInitDevice("Right");
  hdStartScheduler();
  emulator.step(200);
  in_tick([&] {
    hdBeginFrame(left);
    CHECK(hdGetCurrentDevice() == left);
    const Eigen::Vector3d before = get(HD_CURRENT_POSITION);
    CHECK(before.x() > 10);  // mm: it has followed the hand
    hdEndFrame(left);
  });
  const Eigen::Vector3d framed = get(HD_CURRENT_POSITION);
  emulator.step(100);
  CHECK(get(HD_CURRENT_POSITION) == framed);  // no frame since
  in_tick([&] {
    hdBeginFrame(left);
    CHECK(get(HD_CURRENT_POSITION).x() > framed.x() + 5);
    hdEndFrame(left);
  });
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: one frame a tick, nested or not at all", "[unit]") {
  Emulator emulator(two_devices());
  const HHD left = hdInitDevice("Left");
  hdStartScheduler();
  in_tick([&] {
    hdBeginFrame(left);
    hdBeginFrame(left);
    hdEndFrame(left);
    hdEndFrame(left);
    CHECK(take_errors().empty());
    hdBeginFrame(left);
    CHECK(take_errors() == Codes{HD_ILLEGAL_BEGIN});
    hdEndFrame(left);
    CHECK(take_errors() == Codes{HD_ILLEGAL_END});
    hdDisable(HD_ONE_FRAME_LIMIT);
    hdBeginFrame(left);
    hdEndFrame(left);
    CHECK(take_errors().empty());
  });
  in_tick([&] { hdBeginFrame(left); });  // left open
  CHECK(take_errors() == Codes{HD_FRAME_ERROR});
}

TEST_CASE("emulator: a force is the frame's, and the motors have it from its end on", "[unit]") {
  Emulator emulator;
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  emulator.step(100);  // the ramp is over
  const Eigen::Vector3d force(0, 0.5, 0);
  in_tick([&] {
    hdBeginFrame(device);
    CHECK(get(HD_CURRENT_FORCE).isZero());
    set_force(force);
    CHECK(get(HD_CURRENT_FORCE) == force);
    CHECK(emulator.forces().empty());
    hdEndFrame(device);
  });
  REQUIRE(emulator.forces().size() == 1);
  CHECK(emulator.forces()[0].set == force);
  CHECK(emulator.forces()[0].applied == force);
  emulator.step(100);
  CHECK(emulator.position().y() > 1e-3);  // it pushes
  in_tick([&] {
    hdBeginFrame(device);
    CHECK(get(HD_CURRENT_FORCE).isZero());  // of the frame before
    hdEndFrame(device);
  });
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: parameters have one type and one name", "[unit]") {
  const Emulator emulator;
  hdInitDevice(HD_DEFAULT_DEVICE);
  std::array<HDint, 16> integers{};
  std::array<HDdouble, 16> doubles{};
  hdGetIntegerv(HD_CURRENT_POSITION, integers.data());
  CHECK(take_errors() == Codes{HD_INVALID_INPUT_TYPE});
  hdGetDoublev(HD_CURRENT_BUTTONS, doubles.data());
  CHECK(take_errors() == Codes{HD_INVALID_INPUT_TYPE});
  hdGetDoublev(HD_FORCE_OUTPUT, doubles.data());
  CHECK(take_errors() == Codes{HD_INVALID_ENUM});
  hdSetDoublev(HD_CURRENT_POSITION, doubles.data());
  hdEnable(HD_CURRENT_POSITION);
  hdIsEnabled(HD_CURRENT_POSITION);
  hdGetString(HD_CURRENT_POSITION);
  CHECK(take_errors() == Codes(4, HD_INVALID_ENUM));
  hdGetDoublev(HD_NOMINAL_MAX_FORCE, doubles.data());
  CHECK(doubles[0] == 3.3);
  hdGetDoublev(HD_USABLE_WORKSPACE_DIMENSIONS, doubles.data());
  CHECK(doubles[0] == -80);
  CHECK(doubles[3] == 80);
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: errors are a stack, of all threads or of each", "[unit]") {
  const bool is_per_thread = GENERATE(false, true);
  EmulatorOptions options;
  options.error_stack = is_per_thread ? ErrorStack::per_thread : ErrorStack::global;
  const Emulator emulator(options);
  hdMakeCurrentDevice(5);
  hdInitDevice("nobody");
  std::thread([] { hdUnschedule(9); }).join();
  CHECK(take_errors() == (is_per_thread
                              ? Codes{HD_DEVICE_FAULT, HD_BAD_HANDLE}
                              : Codes{HD_INVALID_OPERATION, HD_DEVICE_FAULT, HD_BAD_HANDLE}));
  CHECK(hdGetError().errorCode == HD_SUCCESS);
  CHECK(std::string(hdGetErrorString(HD_COMM_ERROR)) != hdGetErrorString(HD_SUCCESS));
}

TEST_CASE("emulator: callbacks run in each tick by priority, until they are done", "[unit]") {
  Emulator emulator;
  hdInitDevice(HD_DEFAULT_DEVICE);
  std::string order;
  struct Caller {
    std::string* order;
    char letter;
    int left;
  };
  Caller low{&order, 'l', 2}, high{&order, 'h', 3};
  const auto call = [](void* data) -> HDCallbackCode {
    auto& caller = *static_cast<Caller*>(data);
    *caller.order += caller.letter;
    return --caller.left > 0 ? HD_CALLBACK_CONTINUE : HD_CALLBACK_DONE;
  };
  const HDSchedulerHandle low_handle =
      hdScheduleAsynchronous(call, &low, HD_MIN_SCHEDULER_PRIORITY);
  const HDSchedulerHandle high_handle =
      hdScheduleAsynchronous(call, &high, HD_MAX_SCHEDULER_PRIORITY);
  emulator.step(3);
  CHECK(order.empty());  // the scheduler does not run
  hdStartScheduler();
  emulator.step(5);
  CHECK(order == "hlhlh");
  CHECK(emulator.callback_count() == 0);
  CHECK(take_errors().empty());
  hdUnschedule(low_handle);
  CHECK(take_errors() == Codes{HD_INVALID_OPERATION});
  CHECK(hdWaitForCompletion(high_handle, HD_WAIT_CHECK_STATUS) == HD_FALSE);
  low.left = 4;
  const HDSchedulerHandle again = hdScheduleAsynchronous(call, &low, HD_MIN_SCHEDULER_PRIORITY);
  CHECK(hdWaitForCompletion(again, HD_WAIT_CHECK_STATUS) == HD_TRUE);
  CHECK(hdWaitForCompletion(again, HD_WAIT_INFINITE) == HD_FALSE);
  CHECK(low.left == 0);
}

TEST_CASE("emulator: what is unscheduled runs no more", "[unit]") {
  Emulator emulator;
  hdInitDevice(HD_DEFAULT_DEVICE);
  int count = 0;
  const HDSchedulerHandle handle = hdScheduleAsynchronous(
      [](void* data) -> HDCallbackCode {
        ++*static_cast<int*>(data);
        return HD_CALLBACK_CONTINUE;
      },
      &count, HD_DEFAULT_SCHEDULER_PRIORITY);
  hdStartScheduler();
  emulator.step(4);
  hdUnschedule(handle);
  emulator.step(4);
  CHECK(count == 4);
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: the scheduler refuses what it cannot do", "[unit]") {
  Emulator emulator;
  const auto nothing = [](void*) -> HDCallbackCode { return HD_CALLBACK_CONTINUE; };
  hdStartScheduler();
  CHECK(take_errors() == Codes{HD_TIMER_ERROR});  // no device is open
  hdInitDevice(HD_DEFAULT_DEVICE);
  hdScheduleSynchronous(nothing, nullptr, HD_DEFAULT_SCHEDULER_PRIORITY);
  CHECK(take_errors() == Codes{HD_INVALID_OPERATION});  // nobody would run it
  hdScheduleAsynchronous(nothing, nullptr, 65535);
  CHECK(take_errors() == Codes{HD_INVALID_PRIORITY});
  while (take_errors().empty() && emulator.callback_count() < 1000) {
    hdScheduleAsynchronous(nothing, nullptr, HD_DEFAULT_SCHEDULER_PRIORITY);
  }
  CHECK(emulator.callback_count() < 1000);
  hdScheduleAsynchronous(nothing, nullptr, HD_DEFAULT_SCHEDULER_PRIORITY);
  CHECK(take_errors() == Codes{HD_SCHEDULER_FULL});
  hdStartScheduler();
  CHECK(take_errors().empty());
  hdStartScheduler();
  CHECK(take_errors() == Codes{HD_TIMER_ERROR});  // it runs
  hdSetSchedulerRate(500);
  CHECK(take_errors() == Codes{HD_INVALID_VALUE});  // USB devices have 1000
}

TEST_CASE("emulator: a synchronous callback within a tick runs at once", "[unit]") {
  Emulator emulator;
  hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  std::string order;
  in_tick([&] {
    order += "before ";
    in_tick([&] { order += "within "; });
    order += "after";
  });
  CHECK(order == "before within after");
  CHECK(emulator.scheduler_time() == Approx(1e-3));
}

TEST_CASE("emulator: force ramps from the start, and after errors", "[unit]") {
  Emulator emulator;
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  const double rate = 20;  // N/s
  hdSetDoublev(HD_FORCE_RAMPING_RATE, &rate);
  hdStartScheduler();
  const auto push = [&](double force) {
    in_tick([&] {
      hdBeginFrame(device);
      set_force({force, 0, 0});
      hdEndFrame(device);
    });
    return emulator.forces().back().applied.norm();
  };
  for (int tick = 1; tick <= 50; ++tick) {
    CHECK(push(1) == Approx(std::min(1.0, rate * 1e-3 * tick)));
  }
  hdEnable(HD_SOFTWARE_FORCE_IMPULSE_LIMIT);
  const double limit = 0.5;  // N/ms
  hdSetDoublev(HD_SOFTWARE_FORCE_IMPULSE_LIMIT, &limit);
  CHECK(push(2) == 0);
  CHECK(take_errors() == Codes{HD_EXCEEDED_MAX_FORCE_IMPULSE});
  CHECK(push(2) == Approx(rate * 1e-3));  // the ramp begins anew
  hdDisable(HD_FORCE_RAMPING);
  CHECK(push(2) == 2);
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: too much force is clamped, or refused", "[unit]") {
  Emulator emulator;
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  hdDisable(HD_FORCE_RAMPING);
  hdDisable(HD_SOFTWARE_FORCE_IMPULSE_LIMIT);
  const auto push = [&] {
    in_tick([&] {
      hdBeginFrame(device);
      set_force({3, 4, 0});
      hdEndFrame(device);
    });
    return emulator.forces().back().applied;
  };
  CHECK(push().isApprox(Eigen::Vector3d(3, 4, 0) * (3.3 / 5)));
  CHECK(take_errors().empty());
  hdDisable(HD_MAX_FORCE_CLAMPING);
  CHECK(push().isZero());
  CHECK(take_errors() == Codes{HD_EXCEEDED_MAX_FORCE});
  hdEnable(HD_MAX_FORCE_CLAMPING);
  hdDisable(HD_FORCE_OUTPUT);
  CHECK(push().isZero());
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: a stylus that is thrown is an error of the force", "[unit]") {
  EmulatorOptions options;
  options.devices[0].hand = [](double time) {
    return Hand{.target = {2 * time, 0, 0}, .stiffness = 5000, .damping = 20};  // 2 m/s
  };
  Emulator emulator(options);
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  Codes errors;
  for (int tick = 0; tick < 100 && errors.empty(); ++tick) {
    in_tick([&] {
      hdBeginFrame(device);
      hdEndFrame(device);
    });
    errors = take_errors();
  }
  CHECK(errors == Codes{HD_EXCEEDED_MAX_VELOCITY});
}

TEST_CASE("emulator: positions are millimetres in steps of the encoders", "[unit]") {
  const double resolution = GENERATE(kTouchResolution, kTouchXResolution);
  EmulatorOptions options;
  options.devices[0].position = {0.0101234, -0.0203, 0.0301};
  options.devices[0].resolution = resolution;
  options.devices[0].hand = [](double) {
    return Hand{.rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).matrix(),
                .buttons = HD_DEVICE_BUTTON_2,
                .is_in_inkwell = true};
  };
  Emulator emulator(options);
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdBeginFrame(device);
  const Eigen::Vector3d position = get(HD_CURRENT_POSITION);
  std::array<HDdouble, 16> transform{};
  HDint buttons = 0;
  HDboolean is_in_inkwell = HD_FALSE;
  hdGetDoublev(HD_CURRENT_TRANSFORM, transform.data());
  hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
  hdGetBooleanv(HD_CURRENT_INKWELL_SWITCH, &is_in_inkwell);
  hdEndFrame(device);
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = position[axis] / (1000 * resolution);
    CHECK(std::abs(steps - std::round(steps)) < 1e-6);
    CHECK(std::abs(position[axis] - 1000 * options.devices[0].position[axis]) <
          500.001 * resolution);
    CHECK(transform[static_cast<std::size_t>(12 + axis)] == position[axis]);
  }
  CHECK(transform[1] == Approx(1).margin(1e-3));  // by columns: x to y
  CHECK(transform[4] == Approx(-1).margin(1e-3));
  CHECK(buttons == HD_DEVICE_BUTTON_2);
  CHECK(is_in_inkwell == HD_TRUE);
}

TEST_CASE("emulator: calibration by an update, once the stylus is parked", "[unit]") {
  EmulatorOptions options;
  options.devices[0].calibration = CalibrationNeed::inkwell;
  options.devices[0].hand = [](double time) { return Hand{.is_in_inkwell = time > 0.5}; };
  Emulator emulator(options);
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  const auto position = [&] {
    hdBeginFrame(device);
    const double x = get(HD_CURRENT_POSITION).x();
    hdEndFrame(device);
    emulator.step(1);
    return x;
  };
  hdDisable(HD_ONE_FRAME_LIMIT);
  CHECK(hdCheckCalibration() == HD_CALIBRATION_NEEDS_MANUAL_INPUT);
  hdUpdateCalibration(HD_CALIBRATION_INKWELL);
  CHECK(hdCheckCalibration() == HD_CALIBRATION_NEEDS_MANUAL_INPUT);
  CHECK(position() == Approx(20).margin(0.1));  // mm, that it is off by
  emulator.step(600);
  CHECK(hdCheckCalibration() == HD_CALIBRATION_NEEDS_UPDATE);
  hdUpdateCalibration(HD_CALIBRATION_AUTO);
  CHECK(take_errors() == Codes{HD_INVALID_VALUE});  // not a style of this device
  HDint style = 0;
  hdGetIntegerv(HD_CALIBRATION_STYLE, &style);
  hdUpdateCalibration(static_cast<HDenum>(style));
  CHECK(hdCheckCalibration() == HD_CALIBRATION_OK);
  CHECK(position() == Approx(0).margin(0.1));
  CHECK(take_errors().empty());
}

TEST_CASE("emulator: time is the thread's or the caller's", "[unit]") {
  Emulator emulator;
  hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  emulator.clock().wait_until(0.25);
  CHECK(emulator.scheduler_time() == Approx(0.25).margin(1.1e-3));
  CHECK(hdGetSchedulerTimeStamp() == 0);
  emulator.inject({.fault = Fault::clock_jump, .begin = 0.3});
  emulator.step(100);
  CHECK(emulator.clock().now() == Approx(0.35 + kClockJump).margin(1.1e-3));
  CHECK(emulator.scheduler_time() == Approx(0.35).margin(1.1e-3));
}

TEST_CASE("emulator: friction holds a stylus, a hand moves it, a force pushes it", "[unit]") {
  EmulatorOptions options;
  options.devices[0].friction = 0.2;
  Emulator emulator(options);
  const HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  hdStartScheduler();
  const auto push = [&](double force) {
    for (int tick = 0; tick < 200; ++tick) {
      in_tick([&] {
        hdBeginFrame(device);
        set_force({force, 0, 0});
        hdEndFrame(device);
      });
    }
    return emulator.position().x();
  };
  CHECK(push(0.19) == 0);
  CHECK(push(0.5) > 0.02);
}

TEST_CASE("emulator: options and plans out of range are refused", "[unit]") {
  EmulatorOptions options;
  options.devices[0].mass = 0;
  CHECK_THROWS_AS(Emulator(options), pbdsurg::InvalidArgument);
  options = two_devices();
  options.devices[1].name = "Left";
  CHECK_THROWS_AS(Emulator(options), pbdsurg::InvalidArgument);
  options.devices.clear();
  CHECK_THROWS_AS(Emulator(options), pbdsurg::InvalidArgument);
  Emulator emulator;
  CHECK_THROWS_AS(Emulator{}, pbdsurg::InvalidArgument);  // a second one
  CHECK_THROWS_AS(emulator.inject({.fault = Fault::unplugged, .begin = 0, .device = 1}),
                  pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(emulator.inject({.fault = Fault::swapped_devices, .begin = 0}),
                  pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(emulator.inject({.fault = Fault::unplugged, .begin = -1}),
                  pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(emulator.step(-1), pbdsurg::InvalidArgument);
}

TEST_CASE("emulator: without one, nothing is plugged in", "[unit]") {
  CHECK(hdInitDevice(HD_DEFAULT_DEVICE) == HD_INVALID_HANDLE);
  CHECK(take_errors() == Codes{HD_DEVICE_FAULT});
}

}  // namespace hdapi_emulator
