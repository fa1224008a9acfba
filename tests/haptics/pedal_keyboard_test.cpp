// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/pedal_keyboard.h"

#include <cerrno>
#include <cstring>
#include <vector>

#include "lib/haptics/open_device.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/eventually.h"
#include "tests/support/pedal_pipe.h"

namespace pbdsurg {
namespace {

constexpr PedalKeys kKeys{.cut = KEY_A, .coagulation = KEY_B};

// A pipe of keys, polled each millisecond of virtual time.
class PedalBench {
 public:
  void run(double seconds) {
    const double end = clock.now() + seconds;
    while (clock.now() < end - 1e-9) {
      clock.advance(1e-3);
      poll();
    }
  }
  void poll() {
    if (pedals.poll()) {
      events.push_back(pedals.event());
    }
  }

  VirtualClock clock;
  testing::PedalPipe keys;
  PedalKeyboard pedals{keys.path, kKeys, clock};
  std::vector<PedalEvent> events;
};

}  // namespace

// Would catch pedals exchanged, an event that waits for the debounce, a wrong time, and a key that
// is held and taken for one that is pressed again.
TEST_CASE("pedals: each key is its pedal, at the time of the poll", "[unit]") {
  PedalBench bench;
  bench.run(0.1);
  CHECK(bench.events.empty());
  bench.keys.key(KEY_A, 1);
  bench.run(0.001);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].pedals == Pedals{.cut = true});
  CHECK(bench.events[0].time == bench.clock.now());
  bench.keys.key(KEY_A, 2);
  bench.keys.key(KEY_C, 1);  // of no pedal
  bench.run(0.1);
  CHECK(bench.events.size() == 1);
  bench.keys.key(KEY_A, 0);
  bench.run(0.001);
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].pedals == Pedals{});
  bench.run(0.1);
  bench.keys.key(KEY_B, 1);
  bench.run(0.001);
  REQUIRE(bench.events.size() == 3);
  CHECK(bench.events[2].pedals == Pedals{.coagulation = true});
  CHECK(bench.events[2].cause == PedalCause::foot);
}

// Would catch a generator that goes on while a foot is on both.
TEST_CASE("pedals: both together activate nothing", "[unit]") {
  PedalBench bench;
  bench.keys.key(KEY_A, 1);
  bench.run(0.1);
  CHECK(activation_of(bench.pedals.event().pedals) == Activation::cut);
  bench.keys.key(KEY_B, 1);
  bench.run(0.1);
  CHECK(bench.pedals.event().pedals == Pedals{true, true});
  CHECK(activation_of(bench.pedals.event().pedals) == Activation::none);
  bench.keys.key(KEY_A, 0);
  bench.run(0.1);
  CHECK(activation_of(bench.pedals.event().pedals) == Activation::coagulation);
}

// Would catch a bounce that counts, in one poll or in many, and one that ends with the wrong state.
TEST_CASE("pedals: contacts that bounce give one event", "[unit]") {
  const int polls_between = GENERATE(0, 1, 3);  // six changes, 18 ms at most
  PedalBench bench;
  for (int change = 0; change < 7; ++change) {
    bench.keys.key(KEY_A, change % 2 == 0 ? 1 : 0);
    bench.run(1e-3 * polls_between);
  }
  bench.run(0.2);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].pedals.cut);

  for (int change = 0; change < 7; ++change) {
    bench.keys.key(KEY_A, change % 2);
    bench.run(1e-3 * polls_between);
  }
  bench.run(0.2);
  REQUIRE(bench.events.size() == 2);
  CHECK_FALSE(bench.events[1].pedals.cut);
}

// Would catch a pedal that sticks after a tap within the debounce.
TEST_CASE("pedals: a tap shorter than the debounce ends with it", "[unit]") {
  PedalBench bench;
  bench.keys.key(KEY_A, 1);
  bench.keys.key(KEY_A, 0);
  bench.run(0.1);
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].time - bench.events[0].time ==
        testing::Approx(PedalKeyboard::kDebounce).margin(1.1e-3));
}

// Would catch a generator that burns on, or an exception, when the cable is pulled.
TEST_CASE("pedals: a keyboard that is gone has its pedals up", "[unit]") {
  PedalBench bench;
  bench.keys.key(KEY_A, 1);
  bench.run(0.1);
  CHECK(bench.pedals.is_connected());
  bench.keys.unplug();
  bench.run(0.1);
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].pedals == Pedals{});
  CHECK(bench.events[1].cause == PedalCause::disconnected);
  CHECK_FALSE(bench.pedals.is_connected());

  bench.keys.plug_in();
  bench.run(1);
  CHECK(testing::eventually([&] {
    bench.poll();
    return bench.pedals.is_connected();
  }));
  bench.keys.key(KEY_A, 2);  // still held
  bench.run(0.1);
  CHECK(bench.events.size() == 2);
  bench.keys.key(KEY_A, 1);
  bench.run(0.1);
  CHECK(bench.events.size() == 3);
}

// Would catch a record that begins before a keyboard is gone and ends with another's first bytes.
TEST_CASE("pedals: what was left of a record is gone with its keyboard", "[unit]") {
  PedalBench bench;
  bench.keys.bytes("half", 4);
  bench.run(0.001);
  bench.keys.unplug();
  bench.run(0.001);
  bench.keys.plug_in();
  bench.run(1);
  REQUIRE(testing::eventually([&] {
    bench.poll();
    return bench.pedals.is_connected();
  }));
  bench.keys.key(KEY_A, 1);
  bench.run(0.001);
  CHECK(bench.events.size() == 1);
}

// Would catch current that flows again after a pause in which nobody saw the foot, and presses that
// were kept for later; also a foot that must lift twice.
TEST_CASE("pedals: after a stall, lost events or an order they are up until pressed anew",
          "[unit]") {
  const PedalCause cause = GENERATE(PedalCause::stall, PedalCause::overflow, PedalCause::let_go);
  PedalBench bench;
  bench.keys.key(KEY_A, 1);
  bench.run(0.1);
  REQUIRE(bench.events.size() == 1);
  switch (cause) {
    case PedalCause::stall:
      bench.keys.key(KEY_B, 1);  // in the pause
      bench.clock.advance(PedalKeyboard::kStall + 0.01);
      bench.poll();
      break;
    case PedalCause::overflow:
      bench.keys.record(EV_SYN, SYN_DROPPED, 0);
      bench.run(0.001);
      break;
    default:
      CHECK(bench.pedals.let_go());
      CHECK_FALSE(bench.pedals.let_go());
      bench.events.push_back(bench.pedals.event());
  }
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].pedals == Pedals{});
  CHECK(bench.events[1].cause == cause);
  bench.keys.key(KEY_A, 2);  // still held
  bench.run(1);
  CHECK(bench.events.size() == 2);
  bench.keys.key(KEY_A, 0);
  bench.run(0.1);
  bench.keys.key(KEY_A, 1);
  bench.run(0.1);
  REQUIRE(bench.events.size() == 3);
  CHECK(bench.events[2].pedals == Pedals{.cut = true});
}

// Would catch a slow program, or one at the limit itself, that loses its pedals.
TEST_CASE("pedals: polls as far apart as a quarter of a second are no stall", "[unit]") {
  PedalBench bench;
  bench.keys.key(KEY_A, 1);
  for (int poll = 0; poll < 20; ++poll) {
    bench.clock.advance(PedalKeyboard::kStall - 1e-6);
    bench.poll();
  }
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].pedals.cut);
}

// Would catch records that are lost or shifted where a read breaks them, and a full buffer that
// looks like the end.
TEST_CASE("pedals: records arrive in pieces and in crowds", "[unit]") {
  PedalBench bench;
  input_event press{};
  press.type = EV_KEY;
  press.code = KEY_B;
  press.value = 1;
  char bytes[sizeof(press)];
  std::memcpy(bytes, &press, sizeof(press));
  for (const char byte : bytes) {
    CHECK(bench.events.empty());
    bench.keys.bytes(&byte, 1);
    bench.run(0.001);
  }
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].pedals.coagulation);
  bench.run(0.1);
  const char nothing[sizeof(press)] = {};  // a record of no meaning, in two pieces
  bench.keys.bytes(nothing, 7);
  bench.keys.bytes(nothing, sizeof(press) - 7);
  for (int record = 0; record < 200; ++record) {
    bench.keys.record(EV_MSC, MSC_SCAN, record);
  }
  bench.keys.key(KEY_B, 0);
  bench.run(0.001);
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.pedals.is_connected());
}

// Would catch two pedals on one key, which could not be told apart, and keys that are none.
TEST_CASE("pedals: keys that cannot be pedals are refused", "[unit]") {
  const VirtualClock clock;
  const testing::PedalPipe keys;
  const auto make = [&](int cut, int coagulation) {
    PedalKeyboard(keys.path,
                  {static_cast<std::uint16_t>(cut), static_cast<std::uint16_t>(coagulation)},
                  clock);
  };
  testing::check_refused([&] { make(KEY_A, KEY_A); }, "are 30 for cut and 30 for coagulation");
  testing::check_refused([&] { make(0, 0); }, "or one and 0");
  testing::check_refused([&] { make(KEY_MAX + 1, 0); }, "from 1 to 767");
  CHECK_NOTHROW(make(KEY_A, 0));
  CHECK_NOTHROW(make(0, KEY_A));
}

// Would catch an error that leaves a person alone. Those who run tests may read all files, so that
// the sentence is looked at by itself.
TEST_CASE("pedals: a keyboard that cannot be opened says what to do", "[unit]") {
  const VirtualClock clock;
  CHECK_THROWS_AS(PedalKeyboard("/dev/input/none", kKeys, clock), FileError);
  CHECK_THROWS_WITH(PedalKeyboard("/dev/input/none", kKeys, clock),
                    "/dev/input/none: there is no such device; plug the pedals in and look for "
                    "them with ls /dev/input/by-id");
  CHECK_THROWS_WITH(PedalKeyboard("/dev/null", kKeys, clock),
                    "/dev/null: is neither an input device nor a pipe");
  CHECK(open_refusal("/dev/input/event5", EACCES, {"ask", "plug it in"}) ==
        "/dev/input/event5: you are not allowed to read it; ask");
  CHECK(open_refusal("/dev/input/event5", EBUSY, {"ask", "plug it in"}) ==
        "/dev/input/event5: another program has it; end that program");
}

}  // namespace pbdsurg
