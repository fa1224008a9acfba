// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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
  explicit Desk(const RigDescription& description) : rig(description, places(), true) {
    rig.begin({});
  }

  pbdsurg::Clock& clock() { return rig.clock(); }

  void run(double seconds) {
    for (int tick = 0; tick < static_cast<int>(1e3 * seconds + 0.5); ++tick, ++ticks_) {
      if (ticks_ % 10 == 0) {
        for (const Side side : kSides) {
          step(side);
        }
        pedals.push_back(rig.feet().state().pedals);
        rig.poll();
      }
      rig.tick();
      for (const Side side : kSides) {
        if (rig.has_servo(side)) {
          note(side);
        }
      }
    }
  }

  [[nodiscard]] const pbdsurg::DeviceState& state(Side side) const {
    return states_[static_cast<std::size_t>(side)];
  }
  [[nodiscard]] Vector3f felt(Side side) const { return rig.last_tick(side).force.commanded; }

 private:
  void step(Side side) {
    const pbdsurg::DeviceState state = rig.device(side).state();
    states_[static_cast<std::size_t>(side)] = state;
    const float height = state.pose.translation().z();
    pbdsurg::ContactPacket packet;
    packet.sequence = static_cast<std::uint64_t>(ticks_) + 1;
    packet.time = clock().now();
    pbdsurg::set_pose(packet, state.pose);
    packet.force = {0, 0, 100 * std::max(0.0F, -height)};
    packet.planes[0] = {.normal = {0, 0, 1}, .stiffness = 100};
    packet.plane_count = 1;
    rig.publish(side, packet);
  }

  void note(Side side) {
    Vector3f& before = before_[static_cast<std::size_t>(side)];
    worst_step = std::max(worst_step, (felt(side) - before).norm());
    worst_force = std::max(worst_force, felt(side).norm());
    before = felt(side);
  }

  std::array<pbdsurg::DeviceState, 2> states_;
  std::array<Vector3f, 2> before_{Vector3f::Zero(), Vector3f::Zero()};
  int ticks_ = 0;

 public:
  Rig rig;
  float worst_step = 0;                 // N, in a tick
  float worst_force = 0;                // N
  std::vector<pbdsurg::Pedals> pedals;  // of each step
};

using pbdsurg::MappedInstrument;

// The arm whose instrument is so deep.
Eigen::Isometry3f arm_for(const HandDescription& hand, Side side, float depth) {
  Vector3f tip = places().tips[static_cast<std::size_t>(side)];
  tip.z() = -depth;
  return Eigen::Isometry3f(Eigen::Translation3f(mapping_of(hand, places(), side).arm_at(tip)));
}

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
    rig.rehearse({press(Side::left), press(Side::right)});
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
      // at a handle the shaft's lever turns it over
      const Vector3f at_tip(0, 0, 100 * depth);
      const MappedInstrument mapped = mapping_of(description.hand(side), places(), side)
                                          .map(arm_for(description.hand(side), side, depth));
      CHECK((desk.felt(side) - mapped.lever.transpose() * at_tip).norm() < 0.1F * at_tip.norm());
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
}

// Would catch feet that are an arm's: who loses one would lose all current with it.
TEST_CASE("rig: pedals outlive an arm", "[unit]") {
  for (const Side side : kSides) {
    RigDescription description = emulator();
    description.faults.push_back({"unplugged", side, 2.5});
    const PressingDesk desk(description, 3.5);
    CHECK(!desk.state(side).is_connected);
    CHECK(desk.pedals.back() == pbdsurg::Pedals{.cut = true});
  }
}

// Would catch jaws that a lost arm keeps closed.
TEST_CASE("rig: the jaws of a lost arm open", "[unit]") {
  RigDescription description = emulator();
  description.faults.push_back({"unplugged", Side::left, 3.5});
  PressingDesk desk(description, 3.4);
  REQUIRE(desk.state(Side::left).jaw == 0);
  desk.run(0.6);
  CHECK(desk.state(Side::left).jaw == 1);
  CHECK(desk.state(Side::right).jaw == 0);
}

// Would catch a panel that goes on showing the force of the tick before an arm was lost, whichever
// tick that was.
TEST_CASE("rig: what is told of a lost arm is its end", "[unit]") {
  for (int tick = 0; tick < 10; ++tick) {
    RigDescription description = emulator();
    description.faults.push_back({"unplugged", Side::left, 2.5 + 1e-3 * tick});
    PressingDesk desk(description, 2.9);
    REQUIRE(desk.worst_force > 0.4F);
    const HandStatus& status = desk.rig.status(Side::left);
    CHECK(status.arm.is_lost);
    CHECK(!status.is_connected);
    CHECK(status.servo.force.commanded.isZero(0));
    CHECK(status.servo.engaged == 0);
    CHECK(status.servo.faults.count(pbdsurg::ServoFault::device_lost) == 1);
  }
}

// Would catch a kick where an undo puts tissue back around a tip.
TEST_CASE("rig: after the scene has leapt, force is let in anew", "[unit]") {
  PressingDesk desk(emulator(), 2.9);
  REQUIRE(desk.felt(Side::left).z() > 0.4F);
  desk.rig.disengage();
  desk.run(0.1);
  CHECK(desk.felt(Side::left).isZero(0));
  CHECK(desk.worst_step <= 0.2001F);
  desk.run(1);
  CHECK(desk.felt(Side::left).isZero(0));  // still in the tissue
}

// Would catch anything that depends on wall time or on addresses.
TEST_CASE("rig: virtual time gives the same bits each time", "[property]") {
  const auto run = [] {
    const PressingDesk desk(emulator(), 3.5);
    std::vector<float> values;
    for (const Side side : kSides) {
      CHECK(desk.rig.last_tick(side).tick_count == 3500);
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
    description.hands[0].serial_number = "7";  // else nobody notices another device
    description.hands[1].serial_number = "8";
    description.faults.push_back({fault, Side::left, 2.5, 1.2});  // serial numbers: once a second
    PressingDesk desk(description, 6);
    CHECK(desk.worst_force <= 2.6001F);
    CHECK(desk.worst_step <= 0.2001F);
    CHECK(desk.state(Side::left).pose.matrix().allFinite());
    if (fault != "clock jump" && fault != "dropped tick" && fault != "late tick" &&
        fault != "swapped devices") {
      CHECK(desk.felt(Side::right).z() > 0.4F);  // the other hand goes on
    }
    std::uint64_t counted = 0;
    const HandStatus& status = desk.rig.status(Side::left);
    for (std::size_t i = 0; i < kDeviceFaultCount; ++i) {
      counted += status.arm.faults.of(static_cast<DeviceFault>(i));
    }
    for (std::size_t i = 0; i < pbdsurg::kServoFaultCount; ++i) {
      counted += status.servo.faults.count(static_cast<pbdsurg::ServoFault>(i));
    }
    CHECK((counted > 0 || fault == "stuck calibration"));  // which is over before it begins
  }
}

// Would catch an arm that is lost while a slow machine still makes the scene.
TEST_CASE("rig: times of faults count from the scene's begin", "[unit]") {
  RigDescription description = emulator();
  description.faults.push_back({"unplugged", Side::left, 1});
  description.faults.push_back({"warm motors", Side::right, 0});
  Rig rig(description, places(), true);
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      rig.tick();
    }
    rig.device(Side::left).state();
    rig.device(Side::right).state();
    rig.poll();
  };
  run(1500);
  CHECK(rig.status(Side::left).is_connected);
  CHECK(rig.status(Side::right).arm.faults.of(DeviceFault::warm_motors) > 0);
  rig.begin({});
  run(900);
  CHECK(rig.status(Side::left).is_connected);
  run(200);
  CHECK(!rig.status(Side::left).is_connected);
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

// Would catch a recorded hand whose servo runs on other poses than its simulation sees: the
// packet's point is beside the origin of an instrument that lies along x.
TEST_CASE("rig: a recorded hand feels what it touches", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  pbdsurg::DeviceTrace trace;
  trace.name = "hand";
  for (int i = 0; i < 400; ++i) {
    pbdsurg::DeviceSample sample;
    sample.asked = sample.state.time = 0.01 * i;
    const float height = std::clamp(0.03F - 1e-4F * static_cast<float>(i), 0.001F, 0.02F);
    sample.state.pose = Eigen::Translation3f(0.02F, 0.01F, height) *
                        Eigen::AngleAxisf(std::numbers::pi_v<float> / 2, Vector3f::UnitY());
    trace.samples.push_back(sample);
  }
  const std::filesystem::path path = folder / "hand.trace";
  pbdsurg::write_device_trace(path, trace);
  Rig rig(read_rig(path.string()), places(), true);
  rig.begin({});
  CHECK(rig.longest_trace() == Approx(3.99));
  CHECK(!rig.has_servo(Side::left));
  for (int tick = 0; tick < 3900; ++tick) {
    if (tick % 10 == 0) {
      pbdsurg::ContactPacket packet;
      packet.sequence = static_cast<std::uint64_t>(tick) + 1;
      packet.time = rig.clock().now();
      pbdsurg::set_pose(packet, rig.device(Side::right).state().pose);
      packet.planes[0] = {.point = {0.005F, 0, 0}, .normal = {0, 0, 1}, .stiffness = 600};
      packet.plane_count = 1;  // the point is 5 mm below the tip, as x points down
      packet.force = pbdsurg::packet_vector(pbdsurg::plane_force(packet, pbdsurg::pose_of(packet)));
      rig.publish(Side::right, packet);
    }
    rig.tick();
  }
  CHECK(rig.last_tick(Side::right).force.computed.z() == Approx(0.25 * 600 * 0.004).epsilon(0.05));
  for (int tick = 0; tick < 500; ++tick) {
    rig.tick();
  }
  CHECK(!rig.device(Side::right).state().is_connected);
  CHECK(!rig.status(Side::right).is_connected);
  CHECK(rig.last_tick(Side::right).force.commanded.isZero(0));
  rig.begin({});  // as when a play begins anew
  CHECK(rig.device(Side::right).state().is_connected);
}

// Would catch a foot that decides what a run in virtual time does.
TEST_CASE("rig: virtual time has no real devices", "[unit]") {
  RigDescription description = emulator();
  description.pedals.push_back({"/dev/input/event0", {1, 2}});
  pbdsurg::testing::check_refused([&] { Rig rig(description, places(), true); }, "event0");
  description = emulator();
  description.hands[0].handle = HandleDescription{"/dev/ttyACM7", {}};
  pbdsurg::testing::check_refused([&] { Rig rig(description, places(), true); }, "ttyACM7");
  description = read_rig("openhaptics");
  pbdsurg::testing::check_refused([&] { Rig rig(description, places(), true); }, "real time");
}

}  // namespace rig
