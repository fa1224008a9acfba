// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"

namespace rig {

// Catches memory that a tick takes: an allocator may wait.
TEST_CASE("hdapi: ticks, states and polls allocate nothing", "[unit]") {
  hdapi_emulator::Emulator emulator(testing::two_hands());
  testing::Wall left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(10);
  const long before = pbdsurg::testing::allocation_count;
  for (int frame = 0; frame < 10; ++frame) {
    session.poll();
    emulator.step(10);
    static_cast<void>(session.device(0).state());
    static_cast<void>(session.device(0).status());
  }
  const long after = pbdsurg::testing::allocation_count;
  CHECK(after == before);
}

}  // namespace rig
