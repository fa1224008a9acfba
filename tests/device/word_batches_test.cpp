// SPDX-License-Identifier: Apache-2.0
#include "lib/device/word_batches.h"

#include <cstdint>
#include <vector>

#include "tests/support/catch.h"

namespace pbdsurg::cuda {

// Would catch an edit whose words are written beside those of the one before, which may be the
// same, or before them.
TEST_CASE("word batches: they follow each other") {
  WordBatches batches;
  const auto add = [&](std::uint32_t value) {
    batches.last().push_back({DeviceArray::volumes, 7, value});
  };
  batches.begin();  // of none
  CHECK(batches.words().empty());
  add(1);
  add(2);
  batches.begin();
  batches.begin();  // once more, with nothing in between
  add(3);
  CHECK(batches.words().size() == 2);
  batches.begin();
  REQUIRE(batches.words().size() == 3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    CHECK(batches.words()[i].value == i + 1);
  }
  CHECK(std::vector(batches.ends().begin(), batches.ends().end()) ==
        std::vector<std::size_t>{2, 3});
  add(4);
  batches.clear();
  batches.begin();
  CHECK(batches.words().empty());
  CHECK(batches.ends().empty());
}

}  // namespace pbdsurg::cuda
