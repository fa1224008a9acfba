// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "pbdsurg/base/mailbox.h"

#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"

namespace pbdsurg {

using testing::allocation_count;

// Would catch slots that are made anew, or buffers that do not come back: a servo thread must not
// wait for memory.
TEST_CASE("mailbox: values that keep their size are handed over without an allocation", "[unit]") {
  const bool has_first = GENERATE(true, false);
  Mailbox<std::vector<float>> box{has_first ? std::vector<float>(300) : std::vector<float>()};
  const std::vector<float> value(300, 1.0F);
  long before = allocation_count;
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < round % 4; ++i) {
      box.draft().assign(value.begin(), value.end());
      box.publish();
    }
    if (round % 5 != 0) {
      box.take();
    }
    if (round == 5 && !has_first) {  // all slots have been filled once
      CHECK(allocation_count == before + 3);
      before = allocation_count;
    }
  }
  CHECK(allocation_count == before);
  CHECK(box.value() == value);
}

}  // namespace pbdsurg
