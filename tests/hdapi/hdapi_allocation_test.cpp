// SPDX-License-Identifier: Apache-2.0
#include <mutex>

#include <HD/hd.h>

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"
#include "tests/hdapi/wall_servo.h"
#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"
#include "tests/support/lock_count.h"

namespace rig {

// Catches memory that a tick takes, and a lock, in the driver or in the servo: both may wait.
TEST_CASE("hdapi: ticks with servos, states and polls allocate nothing and take no lock",
          "[unit]") {
  using pbdsurg::testing::allocation_count;
  using pbdsurg::testing::lock_count;
  hdapi_emulator::Emulator emulator(testing::two_hands());
  testing::WallServo left(emulator), right(emulator);
  HdapiSession session(testing::feel(left, right), emulator.clock());
  emulator.step(10);
  // the emulator, whose calls take a lock of its own each, is no part of what is tested
  static_cast<void>(hdGetCurrentDevice());
  pbdsurg::testing::mutex_that_is_left_out = pbdsurg::testing::last_locked_mutex.load();
  const long locks_before = lock_count;
  const long allocations_before = allocation_count;
  for (int frame = 0; frame < 10; ++frame) {
    session.poll();
    emulator.step(10);
    static_cast<void>(session.device(0).state());
    static_cast<void>(session.device(0).status());
  }
  const long allocations = allocation_count - allocations_before;
  const long locks = lock_count - locks_before;
  std::mutex mutex;  // shows that locks are counted
  const std::lock_guard lock(mutex);
  const long locks_with_one = lock_count - locks_before;
  CHECK(allocations == 0);
  CHECK(locks == 0);
  CHECK(locks_with_one == 1);
  CHECK(left.records.size() == 110);
}

}  // namespace rig
