// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/haptics/device_trace.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/temporary_folder.h"

namespace rig {
namespace {

using Eigen::Vector3f;
using pbdsurg::testing::Approx;

RigPlaces places() {
  RigPlaces places;
  places.ports = {Vector3f(-0.05F, 0, 0.15F), Vector3f(0.05F, 0, 0.15F)};
  places.tips = {Vector3f(-0.05F, 0, 0.01F), Vector3f(0.05F, 0, 0.01F)};
  places.axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // a scene whose up is z
  return places;
}

// Both hands above tissue of 100 N/m below z = 0, in virtual time.
class Desk {
 public:
  explicit Desk(RigDescription description) : description_(std::move(description)) {
    if (description_.is_emulated) {
      emulated_ = emulate(description_,
                          {mapping_of(description_.hands[0], places(), Side::left),
                           mapping_of(description_.hands[1], places(), Side::right)},
                          places().tips, true);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      resting_[i] = pbdsurg::scripted_hand("nobody", {{.tip = places().tips[i]}}, clock());
    }
    rig = std::make_unique<Rig>(description_, places(),
                                std::array{resting_[0].get(), resting_[1].get()}, emulated_.get(),
                                clock(), true);
  }

  pbdsurg::Clock& clock() { return emulated_ ? emulated_->clock() : own_clock_; }

  void run(double seconds) {
    for (int tick = 0; tick < static_cast<int>(1e3 * seconds + 0.5); ++tick, ++ticks_) {
      if (ticks_ % 10 == 0) {
        for (const Side side : kSides) {
          step(side);
        }
      }
      rig->tick();
      for (const Side side : kSides) {
        if (rig->has_servo(side)) {
          note(side);
        }
      }
    }
  }

  [[nodiscard]] const pbdsurg::DeviceState& state(Side side) const {
    return states_[static_cast<std::size_t>(side)];
  }
  [[nodiscard]] Vector3f felt(Side side) const { return rig->last_tick(side).force.commanded; }

 private:
  void step(Side side) {
    const pbdsurg::DeviceState state = rig->device(side).state();
    states_[static_cast<std::size_t>(side)] = state;
    if (side == Side::right) {
      pedals.push_back(state.pedals);
    }
    const float height = state.pose.translation().z();
    pbdsurg::ContactPacket packet;
    packet.sequence = static_cast<std::uint64_t>(ticks_) + 1;
    packet.time = clock().now();
    pbdsurg::set_pose(packet, state.pose);
    packet.force = {0, 0, 100 * std::max(0.0F, -height)};
    packet.planes[0] = {.normal = {0, 0, 1}, .stiffness = 100};
    packet.plane_count = 1;
    rig->publish(side, packet);
  }

  void note(Side side) {
    Vector3f& before = before_[static_cast<std::size_t>(side)];
    worst_step = std::max(worst_step, (felt(side) - before).norm());
    worst_force = std::max(worst_force, felt(side).norm());
    before = felt(side);
  }

  RigDescription description_;
  pbdsurg::VirtualClock own_clock_;
  std::unique_ptr<EmulatedRig> emulated_;
  std::array<std::unique_ptr<pbdsurg::Device>, 2> resting_;
  std::array<pbdsurg::DeviceState, 2> states_;
  std::array<Vector3f, 2> before_{Vector3f::Zero(), Vector3f::Zero()};
  int ticks_ = 0;

 public:
  std::unique_ptr<Rig> rig;             // the first to go
  float worst_step = 0;                 // N, in a tick
  float worst_force = 0;                // N
  std::vector<pbdsurg::Pedals> pedals;  // of each step
};

RigDescription emulator() {
  RigDescription description = read_rig("emulator");
  for (HandDescription& hand : description.hands) {
    hand.force_scale = 1;
  }
  return description;
}

// Into the tissue at two seconds, with the jaws closed and a pedal down at three.
std::vector<pbdsurg::Waypoint> press(Side side) {
  const Vector3f above = places().tips[static_cast<std::size_t>(side)];
  const Vector3f inside = above - Vector3f(0, 0, 0.02F);
  return {{.time = 0, .tip = above},
          {.time = 1.5, .tip = above},
          {.time = 2, .tip = inside},
          {.time = 3, .tip = inside, .jaw = 0, .pedals = {.cut = side == Side::right}},
          {.time = 20, .tip = inside, .jaw = 0, .pedals = {.cut = side == Side::right}}};
}

struct PressingDesk : Desk {
  PressingDesk(const RigDescription& description, double seconds) : Desk(description) {
    for (const Side side : kSides) {
      rig->rehearse(side, press(side));
    }
    run(seconds);
  }
};

}  // namespace

// Would catch axes that are exchanged anywhere on the way from the stylus to the scene and back to
// the motors: the hand's spring and the tissue's must balance.
TEST_CASE("rig: emulated hands feel tissue, and give way to it", "[unit]") {
  for (const pbdsurg::HeldPart held : {pbdsurg::HeldPart::tip, pbdsurg::HeldPart::handle}) {
    RigDescription description = emulator();
    for (HandDescription& hand : description.hands) {
      hand.held = held;
    }
    const PressingDesk desk(description, 2.9);
    for (const Side side : kSides) {
      const float depth = -desk.state(side).pose.translation().z();
      CHECK(depth > 4e-3F);
      CHECK(depth < 9.5e-3F);  // 10 mm without a force
      const float at_tip = desk.felt(side).z() * (held == pbdsurg::HeldPart::tip ? 1 : 0);
      if (held == pbdsurg::HeldPart::tip) {
        CHECK(at_tip == Approx(100 * depth).epsilon(0.1));
      }
    }
    CHECK(desk.worst_step <= 0.2001F);
  }
}

// Would catch jaws or pedals that do not come through, or those of the other hand.
TEST_CASE("rig: jaws and pedals of emulated hands", "[unit]") {
  PressingDesk desk(emulator(), 2.4);
  CHECK(desk.state(Side::left).jaw == 1);
  CHECK(desk.pedals.back() == pbdsurg::Pedals{});
  desk.run(1.1);
  for (const Side side : kSides) {
    CHECK(desk.state(side).jaw == 0);
  }
  CHECK(desk.pedals.back() == pbdsurg::Pedals{.cut = true});
  CHECK(!desk.state(Side::left).pedals.cut);
}

// Would catch anything that depends on wall time or on addresses.
TEST_CASE("rig: virtual time gives the same bits each time", "[property]") {
  const auto run = [] {
    const PressingDesk desk(emulator(), 3.5);
    std::vector<float> values;
    for (const Side side : kSides) {
      CHECK(desk.rig->last_tick(side).tick_count == 3500);
      const Eigen::Matrix4f pose = desk.state(side).pose.matrix();
      values.insert(values.end(), pose.data(), pose.data() + pose.size());
      const Vector3f felt = desk.felt(side);
      values.insert(values.end(), felt.data(), felt.data() + felt.size());
    }
    return values;
  };
  CHECK(run() == run());
}

// Would catch a fault that reaches the motors as a kick, that stops the other hand, or that nobody
// counts.
TEST_CASE("rig: each fault in the middle of contact", "[unit]") {
  const std::vector<std::string> faults{
      "lost communication",      "dropped tick",  "late tick",   "warm motors",
      "stuck calibration",       "wrong handle",  "force error", "unplugged",
      "NaN from the simulation", "stale packets", "clock jump",  "swapped devices"};
  for (const std::string& fault : faults) {
    CAPTURE(fault);
    RigDescription description = emulator();
    description.faults.push_back({fault, Side::left, 2.5, 0.3});
    const PressingDesk desk(description, 6);
    CHECK(desk.worst_force <= 2.6001F);
    CHECK(desk.worst_step <= 0.2001F);
    CHECK(desk.state(Side::left).pose.matrix().allFinite());
    if (fault != "clock jump" && fault != "dropped tick" && fault != "late tick") {
      CHECK(desk.felt(Side::right).z() > 0.4F);  // the other hand goes on
    }
  }
}

// Would catch a fault under a name that nobody has, or of a hand without an arm.
TEST_CASE("rig: faults that there are not", "[unit]") {
  RigDescription description = emulator();
  description.faults.push_back({"gremlins", Side::left, 1, 1});
  pbdsurg::testing::check_refused([&] { Desk desk(description); }, "unplugged");
  description = read_rig("mouse,emulator");
  description.faults.push_back({"unplugged", Side::left, 1, 1});
  pbdsurg::testing::check_refused([&] { Desk desk(description); }, "holds no arm");
}

// Would catch a recorded hand whose servo runs on other poses than its simulation sees.
TEST_CASE("rig: a recorded hand feels what it touches", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  pbdsurg::DeviceTrace trace;
  trace.name = "hand";
  for (int i = 0; i < 400; ++i) {
    pbdsurg::DeviceSample sample;
    sample.asked = sample.state.time = 0.01 * i;
    const float height =
        i < 200 ? 0.01F : std::max(0.01F - 1e-4F * static_cast<float>(i - 200), -0.006F);
    sample.state.pose.translation() = Vector3f(0, 0, height);
    trace.samples.push_back(sample);
  }
  const std::filesystem::path path = folder / "hand.trace";
  pbdsurg::write_device_trace(path, trace);
  Desk desk(read_rig(path.string()));
  desk.run(3.9);
  CHECK(desk.rig->last_tick(Side::right).force.computed.z() == Approx(0.25 * 0.6).epsilon(0.05));
  CHECK(!desk.rig->has_servo(Side::left));
  desk.run(0.5);
  CHECK(!desk.state(Side::right).is_connected);
  CHECK(desk.felt(Side::right).isZero(0));
}

}  // namespace rig
