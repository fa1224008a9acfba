// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/clock.h"

#include <limits>

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a wait that returns early, or sleeps for a time that has passed.
TEST_CASE("clock: the real one waits until a time", "[unit]") {
  RealClock clock;
  const double start = clock.now();
  clock.wait_until(start + 0.01);
  CHECK(clock.now() >= start + 0.01);
  clock.wait_until(start - 3600);
  CHECK(clock.now() < start + 60);
}

// Would catch a virtual clock that goes by itself, or back.
TEST_CASE("clock: a virtual one goes where it is sent, never back", "[unit]") {
  VirtualClock clock;
  CHECK(clock.now() == 0);
  clock.wait_until(2.5);
  CHECK(clock.now() == 2.5);
  clock.wait_until(1);
  CHECK(clock.now() == 2.5);
  clock.advance(0.5);
  CHECK(clock.now() == 3);
  CHECK_THROWS_WITH(clock.advance(-1), testing::ContainsSubstring("never goes back"));
  CHECK_THROWS_AS(clock.advance(std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
}

}  // namespace pbdsurg
