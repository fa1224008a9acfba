// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/change_log.h"

#include <algorithm>
#include <vector>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

Index covered(const std::vector<SlotRange>& ranges) {
  Index sum = 0;
  for (const auto [first, end] : ranges) {
    sum += end - first;
  }
  return sum;
}

}  // namespace

// Would catch a change that a reader is not told of, however far behind it is, whatever was taken
// back, and however the memory wrapped or grew.
TEST_CASE("change log: every reader is told of every change", "[property]") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    ChangeLog log;
    Index size = 500;
    std::vector<int> array(2000), copy(2000);
    std::uint64_t seen = 0, edit = log.version();
    std::vector<SlotRange> ranges;
    for (std::uint64_t i = 0; i < 60; ++i) {
      edit = log.version();
      std::vector<Index> written;
      const std::uint64_t count = random_bits(seed, i) % (i % 7 == 0 ? 1500 : 40);
      for (std::uint64_t k = 0; k < count; ++k) {
        written.push_back(static_cast<Index>(random_unit(seed, i, k + 1) * size));
        ++array[written.back()];
        log.note(written.back());
      }
      if (i % 5 == 2) {
        for (const Index slot : written) {
          --array[slot];
        }
        log.note_again(edit);
      }
      if (i % 11 == 10) {
        size += 100;
        log.reserve(3 * size);
      }
      if (random_bits(seed, i, 9999) % 3 == 0) {
        const Index gap = i % 2 == 0 ? 1 : ChangeLog::kJoinedGap;
        log.collect(seen, size, ranges, gap);
        seen = log.version();
        Index last = -gap;
        for (const auto [first, end] : ranges) {
          REQUIRE((first >= last + gap && end > first && end <= size));
          last = end;
          std::copy(array.begin() + first, array.begin() + end, copy.begin() + first);
        }
        REQUIRE(copy == array);
        log.collect(seen, size, ranges);
        CHECK(ranges.empty());
      }
    }
  }
}

TEST_CASE("change log: ranges hold the changes and small gaps alone", "[unit]") {
  ChangeLog log;
  const std::uint64_t before = log.version();
  for (const Index slot : {7, 40, 8, 41, 7, 200}) {
    log.note(slot);
  }
  std::vector<SlotRange> ranges;
  log.collect(before, 1000, ranges, 1);
  CHECK(ranges.size() == 3);
  CHECK(covered(ranges) == 5);
  log.collect(before, 1000, ranges, 40);
  CHECK(ranges.size() == 2);
  log.collect(before, 100, ranges, 1);  // slot 200 is no more
  CHECK(covered(ranges) == 4);
  log.collect(0, 1000, ranges);
  CHECK(covered(ranges) == 1000);
}

}  // namespace pbdsurg
