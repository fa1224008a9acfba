// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/handle.h"

#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

#include "apps/rig/handle_emulator.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/emulated_range.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kEmulatedRange;

// A handle and the emulated one, polled each millisecond of virtual time.
class HandleBench {
 public:
  // Runs for some time. @param speaks  whether the board's loop runs
  const HandleState& run(double seconds, bool speaks = true) {
    const double end = clock.now() + seconds;
    while (clock.now() < end - 1e-9) {
      clock.advance(1e-3);
      if (speaks) {
        board.run();
      }
      state = handle.poll();
    }
    return state;
  }

  VirtualClock clock;
  rig::HandleEmulator board{clock};
  Handle handle{board.port(), kEmulatedRange, clock};
  HandleState state;
};

}  // namespace

// Would catch a sketch whose lines are not of the protocol, sensors or buttons that are mixed up, a
// wheel of the wrong sense or unit, and a terminal that changes bytes.
TEST_CASE("handle: what fingers do at the sketch's sensors arrives", "[unit]") {
  HandleBench bench;
  CHECK(bench.handle.poll().condition == HandleCondition::waiting);
  CHECK_FALSE(bench.handle.report());
  CHECK(bench.run(0.1).condition == HandleCondition::live);
  CHECK(bench.state.jaw == 1);
  CHECK(bench.state.buttons == 0);

  bench.board.set_jaw(0.5F);
  bench.board.set_button(1, true);
  bench.board.set_roll(-std::numbers::pi_v<float> / 2);
  bench.run(0.02);
  CHECK(bench.state.jaw == Approx(0.5).margin(1e-3));
  CHECK(bench.state.buttons == 2);
  CHECK(bench.state.roll == Approx(1.5 * std::numbers::pi).margin(1e-2));
  CHECK(bench.state.time == Approx(bench.clock.now()).margin(0.0101));
  CHECK(bench.handle.report()->jaw == 500 * 64);

  bench.board.set_jaw(0);
  bench.board.set_button(1, false);
  bench.run(0.02);
  CHECK(bench.state.jaw == 0);
  CHECK(bench.state.buttons == 0);
}

// Would catch lines that are counted twice or not at all: the sketch sends one each 10 ms.
TEST_CASE("handle: a hundred lines come in a second, none is missed", "[unit]") {
  HandleBench bench;
  bench.run(1);
  CHECK(bench.handle.counts().lines == 100);
  CHECK(bench.handle.counts().missed == 0);
  CHECK(bench.handle.counts().refused == 0);
}

// Would catch jaws that open at once, a moment too soon or too late, or with a snap; buttons that
// stay down; and a handle back with closed jaws that snaps them shut.
TEST_CASE("handle: a silent one holds, is lost, opens, and comes back", "[unit]") {
  HandleBench bench;
  bench.board.set_jaw(0);
  bench.board.set_button(0, true);
  bench.run(1);
  REQUIRE(bench.state.jaw == 0);
  const double last = bench.state.time;

  bench.run(last + Handle::kHold - 0.001 - bench.clock.now(), false);
  CHECK(bench.state.condition == HandleCondition::live);
  CHECK(bench.state.jaw == 0);
  CHECK(bench.state.buttons == 1);
  bench.run(0.002, false);
  CHECK(bench.state.condition == HandleCondition::lost);
  CHECK(bench.state.jaw < 0.01F);
  CHECK(bench.state.buttons == 0);
  bench.run(0.249, false);
  CHECK(bench.state.jaw == Approx(0.5).margin(0.005));
  bench.run(0.245, false);
  CHECK(bench.state.jaw < 1);
  bench.run(0.01, false);
  CHECK(bench.state.jaw == 1);
  CHECK(bench.state.time == last);

  bench.run(0.011);
  CHECK(bench.state.condition == HandleCondition::live);
  CHECK(bench.state.buttons == 1);
  CHECK(bench.state.jaw > 0.9F);
  bench.run(0.25);
  CHECK(bench.state.jaw == Approx(0.5).margin(0.05));
  bench.run(0.3);
  CHECK(bench.state.jaw == 0);
  bench.board.set_jaw(1);
  bench.run(0.02);
  CHECK(bench.state.jaw == 1);  // and follows at once again
}

// Would catch jaws whose way depends on how often they are asked for.
TEST_CASE("handle: jaws open by time, whenever they are asked for", "[unit]") {
  HandleBench bench;
  bench.board.set_jaw(0);
  bench.run(1);
  const double last = bench.state.time;
  bench.clock.wait_until(last + Handle::kHold + 0.3);
  CHECK(bench.handle.poll().jaw == Approx(Handle::kJawSpeed * 0.3).epsilon(1e-4));
}

// Would catch a closed port that throws, ends the program or counts as live.
TEST_CASE("handle: a cable that is pulled is a loss", "[unit]") {
  HandleBench bench;
  bench.board.set_jaw(0);
  bench.run(1);
  bench.board.unplug();
  CHECK(bench.run(0.2).condition == HandleCondition::live);
  CHECK(bench.state.jaw == 0);
  CHECK(bench.run(1).condition == HandleCondition::lost);
  CHECK(bench.state.jaw == 1);
}

// Would catch one that is waited for without a cable.
TEST_CASE("handle: a cable that is pulled before the first line is a loss", "[unit]") {
  HandleBench bench;
  bench.board.unplug();
  CHECK(bench.handle.poll().condition == HandleCondition::lost);
  CHECK(bench.handle.poll().condition == HandleCondition::lost);
}

// Would catch a handle that stays lost, one that must be found at its old port, and jaws that snap
// shut when it is back.
TEST_CASE("handle: a cable that is plugged in again brings the handle back", "[unit]") {
  const bool has_spoken = GENERATE(true, false);
  VirtualClock clock;
  const testing::TemporaryFolder folder;
  const auto link = folder / "by-id";
  auto board = std::make_unique<rig::HandleEmulator>(clock);
  std::filesystem::create_symlink(board->port(), link);
  Handle handle(link, kEmulatedRange, clock);
  if (has_spoken) {
    board->run();
    CHECK(handle.poll().condition == HandleCondition::live);
  }
  board->unplug();
  std::filesystem::remove(link);
  for (int second = 0; second < 5; ++second) {
    clock.advance(1);
    CHECK(handle.poll().condition == HandleCondition::lost);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // for an attempt that is in vain
  }

  rig::HandleEmulator again(clock);
  std::filesystem::create_symlink(again.port(), link);
  clock.advance(1);
  again.set_jaw(0);
  CHECK(testing::eventually([&] {
    clock.advance(1e-5);  // lines come each 10 ms
    again.run();
    return handle.poll().condition == HandleCondition::live;
  }));
  CHECK(handle.poll().jaw > 0.9F);
  clock.advance(0.2);
  again.run();
  CHECK(handle.poll().jaw < 0.8F);
}

// Would catch gaps that are not counted, a wrap that is one, and a board that starts anew at 0 and
// seems to have lost 65,000 lines.
TEST_CASE("handle: lines that are missing are counted", "[unit]") {
  HandleBench bench;
  bench.run(1);
  const HandleCounts before = bench.handle.counts();
  for (int line = 0; line < 3; ++line) {  // three lines that never reach the handle
    bench.clock.advance(0.01);
    bench.board.lose_line();
  }
  bench.run(0.05);
  CHECK(bench.handle.counts().missed == before.missed + 3);
  CHECK(bench.state.condition == HandleCondition::live);

  bench.board.restart();
  bench.run(0.2);
  CHECK(bench.handle.counts().lines == before.lines + 5);  // old news, until it was lost
  bench.run(0.2);
  CHECK(bench.handle.counts().missed == before.missed + 3);
  CHECK(bench.state.condition == HandleCondition::live);
}

// Would catch a range upside down, ends that fingers never reach, and a sensor that is not there.
TEST_CASE("handle: a calibration finds both ends", "[unit]") {
  JawCalibration calibration;
  testing::check_refused([&] { static_cast<void>(calibration.range()); }, "2048");
  for (const int reading : {50000, 50010, 30000, 10000, 30000, 50020}) {
    calibration.add(static_cast<std::uint16_t>(reading));
  }
  const JawRange range = calibration.range();
  CHECK(range == JawRange{.closed = 10000, .open = 50020});
  CHECK(jaw_of(range, 0) == 0);
  CHECK(jaw_of(range, 10900) == 0);
  CHECK(jaw_of(range, 30010) == Approx(0.5).margin(1e-3));
  CHECK(jaw_of(range, 49100) == 1);
  CHECK(jaw_of(range, 65535) == 1);

  JawCalibration other;
  for (const int reading : {10000, 50000}) {
    other.add(static_cast<std::uint16_t>(reading));
  }
  CHECK(other.range() == JawRange{.closed = 50000, .open = 10000});
  CHECK(jaw_of(other.range(), 20000) > 0.5F);

  JawCalibration noise;
  for (const int reading : {10000, 12047}) {
    noise.add(static_cast<std::uint16_t>(reading));
  }
  testing::check_refused([&] { static_cast<void>(noise.range()); },
                         "reads 12047 closed and 10000 open");
}

// Would catch a file taken for a port, and errors that do not say what to do.
TEST_CASE("handle: a port that cannot be one is refused", "[unit]") {
  const VirtualClock clock;
  const auto refusal = [&](const std::filesystem::path& path) -> std::string {
    try {
      const Handle handle(path, kEmulatedRange, clock);
    } catch (const FileError& error) {
      return error.what();
    }
    return "none";
  };
  const testing::TemporaryFolder folder;
  CHECK(refusal(folder / "none") == (folder / "none").string() +
                                        ": there is no such device; plug the handle in and look "
                                        "for it with ls /dev/serial/by-id");
  CHECK(refusal(folder.put("file", "")) == (folder / "file").string() + ": is no serial port");
  const rig::HandleEmulator board(clock);
  testing::check_refused([&] { Handle(board.port(), JawRange{1000, 2000}, clock); }, "2048");
  Handle handle(board.port(), kEmulatedRange, clock);
  testing::check_refused([&] { handle.set_range({1000, 2000}); }, "2048");
}

}  // namespace pbdsurg
