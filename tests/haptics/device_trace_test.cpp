// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/device_trace.h"

#include <cstring>
#include <limits>
#include <random>

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/puppet.h"
#include "tests/support/temporary_folder.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::Puppet;
using testing::Strings;

template <class Number>
bool has_same_bits(const Number& a, const Number& b) {
  return std::memcmp(&a, &b, sizeof(Number)) == 0;
}

bool has_same_bits(const DeviceState& a, const DeviceState& b) {
  return has_same_bits(a.time, b.time) && has_same_bits(a.pose.matrix(), b.pose.matrix()) &&
         has_same_bits(a.jaw, b.jaw) && a.buttons == b.buttons && a.pedals == b.pedals &&
         a.is_connected == b.is_connected;
}

// Moves as no hand does, but through every column.
void shake(std::mt19937& random, double time, DeviceState& state) {
  const auto number = [&] { return static_cast<float>(random()) / 4294967296.0F - 0.5F; };
  state.time = time;
  state.pose = Eigen::Translation3f(number() * 1e-3F, number(), -0.0F) *
               Eigen::Quaternionf(number(), number(), number(), number()).normalized();
  state.jaw = number() + 0.5F;
  state.buttons = static_cast<std::uint32_t>(random());
  state.pedals = {.cut = number() > 0, .coagulation = number() > 0};
  state.is_connected = number() > -0.4F;
}

// what a device said at each time it was asked
std::vector<DeviceState> states_of(Device& device, VirtualClock& clock,
                                   const std::vector<double>& times) {
  std::vector<DeviceState> states;
  for (const double time : times) {
    clock.wait_until(time);
    states.push_back(device.state());
  }
  return states;
}

constexpr const char* kGood =
    "# pbdsurg device trace 1\n# name arm\n# begin_s 0\n"
    "# asked_s time_s connected jaw buttons cut coagulation x_m y_m z_m "
    "xx xy xz yx yy yz zx zy zz fx_n fy_n fz_n\n"
    "0.5 0.25 1 0.5 3 1 0 0.01 0.02 0.03 0 1 0 -1 0 0 0 0 1 1 2 -3\n";

std::string with(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.rfind(old);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old.size(), by);
}

}  // namespace

// Would catch a column that is lost, rounded or exchanged, a state that comes a tick early or late,
// a replay that depends on memory or on the real time, and a force that is a sample off.
TEST_CASE("device trace: what was recorded is played again, bit for bit", "[unit]") {
  const testing::TemporaryFolder folder;
  std::vector<double> times;
  std::vector<DeviceState> said;
  DeviceTrace trace;
  {
    VirtualClock clock;
    clock.advance(0.1);
    Strings strings;
    const auto device = recorded(std::make_unique<Puppet>(strings), trace, 1000, clock);
    std::mt19937 random(7);
    for (int tick = 0; tick < 500; ++tick) {
      clock.advance(1e-12 * static_cast<double>(random()));
      shake(random, clock.now() - 1e-4, strings.state);
      times.push_back(clock.now());
      said.push_back(device->state());
      REQUIRE(has_same_bits(said.back(), strings.state));
      const Vector3f force = Vector3f::Constant(static_cast<float>(tick));
      device->set_force(force);
      REQUIRE(strings.force == force);
    }
  }
  write_device_trace(folder / "hand.trace", trace);
  const DeviceTrace read = read_device_trace(folder / "hand.trace");
  CHECK(read.name == "puppet");
  CHECK(read.begin == 0.1);
  REQUIRE(read.samples.size() == 500);
  for (std::size_t i = 0; i < 500; ++i) {
    REQUIRE(read.samples[i].asked == times[i]);
    REQUIRE(read.samples[i].force == Vector3f::Constant(static_cast<float>(i)));
  }
  for (int round = 0; round < 2; ++round) {
    VirtualClock clock;
    clock.advance(0.1);
    const auto replay = replayed(read, clock);
    const auto again = states_of(*replay, clock, times);
    for (std::size_t i = 0; i < said.size(); ++i) {
      INFO("sample " << i);
      REQUIRE(has_same_bits(again[i], said[i]));
    }
  }
}

// Would catch a replay that starts in mid-air, runs on with pedals down, or skips what was not
// asked for in time.
TEST_CASE("device trace: a replay begins and ends not connected, and times are shifted", "[unit]") {
  const testing::TemporaryFolder folder;
  DeviceTrace trace = read_device_trace(folder.put("good", kGood));
  trace.samples.push_back(trace.samples[0]);
  trace.samples[1].asked = 0.75;
  trace.samples[1].state.jaw = 1;
  VirtualClock clock;
  clock.advance(8);
  const auto replay = replayed(trace, clock);
  CHECK(replay->name() == "arm");
  const auto states = states_of(*replay, clock, {8.25, 8.5, 8.625, 8.75, 8.875});
  CHECK_FALSE(states[0].is_connected);
  CHECK(states[0].pedals == Pedals{});
  CHECK(states[1].is_connected);
  CHECK(states[1].time == 8.25);
  CHECK(states[1].pedals == Pedals{.cut = true});
  CHECK(states[1].buttons == 3);
  CHECK(states[1].pose.translation() == Vector3f(0.01F, 0.02F, 0.03F));
  CHECK(states[1].pose.linear() * Vector3f::UnitX() == Vector3f::UnitY());
  CHECK(states[2].jaw == 0.5F);
  CHECK(states[3].jaw == 1);
  CHECK(states[3].is_connected);
  CHECK_FALSE(states[4].is_connected);
  CHECK(states[4].pedals == Pedals{});
  CHECK(states[4].jaw == 1);
}

// Would catch a recorder that allocates in a servo, or overwrites what it has.
TEST_CASE("device trace: what has no room is counted as lost", "[unit]") {
  const VirtualClock clock;
  Strings strings;
  DeviceTrace trace;
  const auto device = recorded(std::make_unique<Puppet>(strings), trace, 3, clock);
  const DeviceSample* const memory = trace.samples.data();
  for (int tick = 0; tick < 10; ++tick) {
    static_cast<void>(device->state());
    device->set_force(Vector3f::Constant(static_cast<float>(tick)));
  }
  const std::size_t kept = trace.samples.size();
  CHECK(kept == 3);
  CHECK(trace.lost == 7);
  CHECK(trace.samples.data() == memory);
  CHECK(trace.samples.back().force == Vector3f::Constant(2));
  CHECK(strings.force == Vector3f::Constant(9));
}

// Would catch a damaged file that plays, or whose error does not say where and why.
TEST_CASE("device trace: bad files are refused with line, value and rule", "[unit]") {
  const testing::TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) -> std::string {
    const auto path = folder.put("hand.trace", text);
    try {
      static_cast<void>(read_device_trace(path));
    } catch (const FileError& error) {
      const std::string message = error.what();
      CHECK(message.substr(0, path.string().size()) == path.string());
      return message.substr(path.string().size());
    }
    return "none";
  };
  const auto check = [&](const std::string& old, const std::string& by, const std::string& reason) {
    CHECK_THAT(refusal(with(kGood, old, by)), testing::ContainsSubstring(reason));
  };
  REQUIRE(refusal(kGood) == "none");
  check("trace 1", "trace 2", ":1: '# pbdsurg device trace 2' stands where");
  check("# name arm", "arm", ":2: 'arm' stands where a line must begin with '# name '");
  check("# begin_s 0", "# begin_s soon", ":3: 'soon' stands where the begin must be");
  check(" fz_n\n", "\n", ":4: ");
  check("0.5 0.25 1", "nan 0.25 1", ":5: the time of asking is nan; it must be finite");
  check("0.5 0.25 1", "-0.5 0.25 1", ":5: it was asked for at -0.5");
  check("0.25 1", "0.25 2", ":5: whether it is connected is 2; it must be 0 to 1");
  check("1 0.5 3", "1 1.5 3", ":5: the jaw is 1.5");
  check("0.5 3 1", "0.5 3.5 1", ":5: '3.5' stands where the buttons must be");
  check("0.5 3 1", "0.5 4294967296 1", ":5: '4294967296' stands where the buttons must be");
  check("0.02", "inf", ":5: the tip is inf; it must be finite");
  check("0.02", "1e99", ":5: '1e99' stands where the tip must be");
  check("0 1 0 -1", "0 1.1 0 -1", ":5: its axes");
  check("0 1 0 -1", "0 -1 0 -1", ":5: its axes");  // left-handed
  check(" -3\n", "\n", ":5: the line ends where the force must be");
  check(" -3\n", " -3 4\n", ":5: '4' stands where the line must end");
  check(" -3\n", " -3", ":5: the file ends within this line; it was cut short");
  check("0.02", "", ":5: '' stands where the tip must be");
  const std::string good = kGood;
  const std::size_t last = good.rfind("0.5 0.25");
  CHECK(refusal(good.substr(0, last)) == ": holds no state; a trace has one at least");
  CHECK_THAT(refusal(good + with(good.substr(last), "0.5 0.25", "0.4 0.25")),
             testing::ContainsSubstring(":6: it was asked for at 0.4"));
  CHECK_THROWS_AS(read_device_trace(folder / "none"), FileError);
  for (std::size_t size = 0; size < good.size(); ++size) {
    REQUIRE(refusal(good.substr(0, size)) != "none");
  }
}

// Would catch a broken device whose record is lost with it.
TEST_CASE("device trace: what is not finite is written, and refused when it is read", "[unit]") {
  const testing::TemporaryFolder folder;
  DeviceTrace trace = read_device_trace(folder.put("good", kGood));
  trace.samples[0].state.jaw = std::numeric_limits<float>::quiet_NaN();
  write_device_trace(folder / "hand.trace", trace);
  CHECK_THROWS_WITH(read_device_trace(folder / "hand.trace"),
                    testing::ContainsSubstring(":5: the jaw is nan; it must be 0"));
}

// Would catch arguments that would play nothing, or break a file.
TEST_CASE("device trace: bad arguments are refused", "[unit]") {
  const VirtualClock clock;
  const testing::TemporaryFolder folder;
  DeviceTrace trace{.name = "arm", .begin = 1, .samples = {}};
  testing::check_refused([&] { static_cast<void>(replayed(trace, clock)); },
                         "the trace of arm holds no sample");
  trace.samples.emplace_back().asked = 0.5;
  testing::check_refused([&] { static_cast<void>(replayed(trace, clock)); }, "sample 0");
  trace.name = "two\nlines";
  testing::check_refused([&] { write_device_trace(folder / "hand.trace", trace); }, "line break");
  Strings strings;
  testing::check_refused(
      [&] { static_cast<void>(recorded(std::make_unique<Puppet>(strings), trace, 0, clock)); },
      "room for 0 samples");
  testing::check_refused([&] { static_cast<void>(recorded(nullptr, trace, 1, clock)); },
                         "must have one");
}

}  // namespace pbdsurg
