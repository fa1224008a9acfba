// SPDX-License-Identifier: Apache-2.0
#include "lib/base/processors.h"

#include <thread>

#include <sched.h>

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch as many threads as the machine has processors where the program may use only some.
TEST_CASE("processors: those that a thread may run on", "[unit]") {
  const int all = processor_count();
  CHECK(all >= 1);
  CHECK(all <= static_cast<int>(std::thread::hardware_concurrency()));
  int pinned = 0;
  bool is_pinned = false;
  std::thread([&] {  // whose affinity ends with it
    const int here = sched_getcpu();
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(here, &one);
    is_pinned = sched_setaffinity(0, sizeof one, &one) == 0;
    pinned = processor_count();
  })
      .join();
  REQUIRE(is_pinned);
  CHECK(pinned == 1);
  CHECK(processor_count() == all);
}

}  // namespace pbdsurg
