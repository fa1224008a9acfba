// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "pbdsurg/haptics/decorators.h"
#include "pbdsurg/haptics/device_trace.h"

#include "apps/rig/handle_emulator.h"
#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"
#include "tests/support/pedal_pipe.h"
#include "tests/support/puppet.h"

namespace pbdsurg {

// Would catch a line, an event or a sample that is put on the heap: a servo must not wait for it.
TEST_CASE("decorators: a hand with all of them allocates nothing while it is used", "[unit]") {
  VirtualClock clock;
  rig::HandleEmulator board(clock);
  testing::PedalPipe keys;
  Handle handle(board.port(), {.closed = 900 * 64, .open = 100 * 64}, clock);
  PedalKeyboard pedals(keys.path, {.cut = KEY_A, .coagulation = KEY_B}, clock);
  testing::Strings strings;
  DeviceTrace trace;
  auto hand = scaled(std::make_unique<testing::Puppet>(strings), {.motion = 2});
  hand = transformed(std::move(hand), Eigen::Isometry3f::Identity());
  hand = with_pedals(with_handle(std::move(hand), handle), pedals);
  hand = recorded(std::move(hand), trace, 2000, clock);
  int downs = 0;
  long allocations = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    clock.advance(1e-3);
    board.run();
    if (tick % 100 == 0) {
      keys.key(KEY_A, tick / 100 % 2);
    }
    const long before = testing::allocation_count;
    downs += hand->state().pedals.cut ? 1 : 0;
    hand->set_force({1, 2, 3});
    allocations += testing::allocation_count - before;
  }
  CHECK(allocations == 0);
  CHECK(downs > 900);
  CHECK(handle.counts().lines == 200);
}

}  // namespace pbdsurg
