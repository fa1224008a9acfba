// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/decorators.h"

#include <limits>
#include <numbers>

#include "apps/rig/handle_emulator.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/emulated_range.h"
#include "tests/support/pedal_pipe.h"
#include "tests/support/puppet.h"

namespace pbdsurg {
namespace {

using Eigen::Isometry3f;
using Eigen::Vector3f;
using testing::Approx;
using testing::kEmulatedRange;
using testing::Puppet;
using testing::Strings;

constexpr float kQuarter = std::numbers::pi_v<float> / 2;

Isometry3f frame(const Vector3f& at, float angle, const Vector3f& axis) {
  return Eigen::Translation3f(at) * Eigen::AngleAxisf(angle, axis);
}

}  // namespace

// Would catch a scale about the wrong point, of the wrong direction, or of the rotation, too.
TEST_CASE("decorators: a scaled device moves and pushes by its scales", "[unit]") {
  Strings strings;
  strings.state.pose = frame({3, 2, 1}, kQuarter, Vector3f::UnitX());
  strings.state.jaw = 0.25F;
  const auto device =
      scaled(std::make_unique<Puppet>(strings), {.motion = 2, .force = 0.5F, .centre = {1, 1, 1}});
  CHECK(device->name() == "puppet");
  const DeviceState state = device->state();
  CHECK(state.pose.translation() == Vector3f(5, 3, 1));
  CHECK(state.pose.linear() == strings.state.pose.linear());
  CHECK(state.jaw == 0.25F);
  device->set_force({2, 4, -6});
  CHECK(strings.force == Vector3f(1, 2, -3));
}

// Would catch a transform from the wrong side, or forces that go the wrong way round: work in the
// scene must be work in the hand.
TEST_CASE("decorators: a transformed device is in the scene's frame, and so are its forces",
          "[unit]") {
  Strings strings;
  const Isometry3f to_scene = frame({1, 0, 0}, kQuarter, Vector3f::UnitZ());
  const Isometry3f instrument = frame({0, 0, 0.1F}, kQuarter, Vector3f::UnitY());
  const auto device = transformed(std::make_unique<Puppet>(strings), to_scene, instrument);
  strings.state.pose = frame({0, 2, 0}, 0, Vector3f::UnitX());
  const DeviceState before = device->state();
  // (0, 2, 0.1) turned by a quarter about z, then moved
  CHECK(before.pose.translation().isApprox(Vector3f(-1, 0, 0.1F), 1e-6F));
  // the shaft points along the hand's +x, the scene's +y
  CHECK((before.pose.linear() * Vector3f::UnitZ()).isApprox(Vector3f::UnitY(), 1e-6F));

  strings.state.pose = frame({0.5F, 2.25F, -1}, 0, Vector3f::UnitX());
  const Vector3f way = device->state().pose.translation() - before.pose.translation();
  const Vector3f force(1, -2, 3);
  device->set_force(force);
  CHECK(strings.force.dot(Vector3f(0.5F, 0.25F, -1)) == Approx(force.dot(way)).epsilon(1e-5));
}

// Would catch a jaw that is still the arm's, buttons that hide one another, a wheel that turns
// about another axis than the shaft, and a lost handle that takes the arm with it.
TEST_CASE("decorators: a handle gives an arm its jaw, wheel and buttons", "[unit]") {
  VirtualClock clock;
  rig::HandleEmulator board(clock);
  Handle handle(board.port(), kEmulatedRange, clock);
  Strings strings;
  strings.state.jaw = 0.1F;
  strings.state.buttons = 2;
  strings.state.pose = frame({1, 2, 3}, 0.3F, Vector3f::UnitY());
  const auto device = with_handle(std::make_unique<Puppet>(strings), handle);
  board.set_jaw(0.5F);
  board.set_roll(kQuarter);
  board.set_button(0, true);
  DeviceState state;
  for (int tick = 0; tick < 1000; ++tick) {
    clock.advance(1e-3);
    board.run();
    state = device->state();
  }
  CHECK(state.jaw == Approx(0.5).margin(1e-3));
  CHECK(state.buttons == (2U | 1U << kFirstHandleButton));
  CHECK(state.pose.translation() == Vector3f(1, 2, 3));
  const Eigen::Matrix3f turn = strings.state.pose.linear().transpose() * state.pose.linear();
  CHECK((turn * Vector3f::UnitX()).isApprox(Vector3f::UnitY(), 0.01F));
  device->set_force({1, 2, 3});
  CHECK(strings.force == Vector3f(1, 2, 3));

  board.unplug();
  clock.advance(1);
  state = device->state();
  CHECK(state.is_connected);
  CHECK(state.jaw == 1);
  CHECK(state.buttons == 2);
}

// Would catch pedals that replace those of the device, and current for an arm that is gone.
TEST_CASE("decorators: pedals join a device, and are up while it is gone", "[unit]") {
  VirtualClock clock;
  testing::PedalPipe yellow, blue;
  PedalKeyboard cut(yellow.path, {.cut = KEY_B}, clock);
  PedalKeyboard coagulation(blue.path, {.coagulation = KEY_B}, clock);  // the same key, elsewhere
  Strings strings;
  const auto device = with_pedals(with_pedals(std::make_unique<Puppet>(strings), cut), coagulation);
  CHECK(device->state().pedals == Pedals{});
  yellow.key(KEY_B, 1);
  clock.advance(0.1);
  CHECK(device->state().pedals == Pedals{.cut = true});
  blue.key(KEY_B, 1);
  clock.advance(0.1);
  CHECK(device->state().pedals == Pedals{true, true});
  strings.state.is_connected = false;
  CHECK(device->state().pedals == Pedals{});
  strings.state = {.pedals = {.coagulation = true}};
  yellow.unplug();
  blue.key(KEY_B, 0);
  clock.advance(0.1);
  CHECK(device->state().pedals == Pedals{.coagulation = true});
  device->set_force({1, 2, 3});
  CHECK(strings.force == Vector3f(1, 2, 3));
}

// Would catch a decorator of nothing, a hand that stands still or is mirrored, and axes that scale.
TEST_CASE("decorators: bad arguments are refused", "[unit]") {
  Strings strings;
  const auto puppet = [&] { return std::make_unique<Puppet>(strings); };
  const auto scale = [&](const DeviceScale& by) { static_cast<void>(scaled(puppet(), by)); };
  const auto place = [&](const Isometry3f& at, const Isometry3f& instrument) {
    static_cast<void>(transformed(puppet(), at, instrument));
  };
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  testing::check_refused([&] { static_cast<void>(scaled(nullptr, {})); }, "must have one");
  testing::check_refused([&] { scale({.motion = 0}); }, "motion scale of a device is 0.0");
  testing::check_refused([&] { scale({.motion = kNone}); }, "motion scale");
  testing::check_refused([&] { scale({.force = -1}); }, "force scale of a device is -1.0");
  testing::check_refused([&] { scale({.centre = {0, kNone, 0}}); }, "centre");
  Isometry3f mirror = Isometry3f::Identity();
  mirror.linear()(0, 0) = -1;
  Isometry3f nowhere = Isometry3f::Identity();
  nowhere.translation().x() = kNone;
  testing::check_refused([&] { place(mirror, Isometry3f::Identity()); }, "to the scene");
  testing::check_refused([&] { place(Isometry3f::Identity(), nowhere); }, "the instrument");
}

}  // namespace pbdsurg
