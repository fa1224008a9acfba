// SPDX-License-Identifier: Apache-2.0
#include "lib/device/range_pool.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg::cuda {

// Would catch ranges that overlap or lie beyond the end, one of a size that was not asked for, room
// that is lost, and neighbours that stay apart.
TEST_CASE("range pool: ranges lie apart, and all that is given back can be had again", "[unit]") {
  constexpr std::size_t kSize = 500;
  RangePool pool(kSize);
  std::vector<RangePool::Range> taken;
  std::vector<bool> is_used(kSize, false);
  std::uint64_t draw = 0;
  const auto below = [&](std::size_t end) {
    return static_cast<std::size_t>(random_unit(3, ++draw) * static_cast<double>(end));
  };
  const auto set_used = [&](const RangePool::Range& range, bool used) {
    for (std::size_t i = range.first; i < range.first + range.size; ++i) {
      REQUIRE(is_used[i] != used);
      is_used[i] = used;
    }
  };
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    if (!taken.empty() && below(2) == 0) {
      std::swap(taken[below(taken.size())], taken.back());
      set_used(taken.back(), false);
      pool.give_back(taken.back());
      taken.pop_back();
      continue;
    }
    const std::size_t least = 1 + below(20);
    const std::size_t wanted = least + below(20);
    if (const auto range = pool.take(least, wanted)) {
      CHECK(range->size >= least);
      CHECK(range->size <= wanted);
      REQUIRE(range->first + range->size <= kSize);
      set_used(*range, true);
      taken.push_back(*range);
    } else {
      ++refused;
      std::size_t longest = 0, run = 0;
      for (const bool used : is_used) {
        run = used ? 0 : run + 1;
        longest = std::max(longest, run);
      }
      CHECK(longest < least);
    }
  }
  CHECK(refused > 10);
  for (const RangePool::Range& range : taken) {
    pool.give_back(range);
  }
  const auto all = pool.take(kSize, kSize);
  REQUIRE(all);
  CHECK(all->first == 0);
  CHECK_FALSE(pool.take(1, 1));
}

}  // namespace pbdsurg::cuda
