// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/random.h"

#include <set>

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch an input that is dropped or two inputs that are mixed symmetrically.
TEST_CASE("random: each of seed, element and round changes the value", "[unit]") {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    for (std::uint64_t element = 0; element < 8; ++element) {
      for (std::uint64_t round = 0; round < 8; ++round) {
        seen.insert(random_bits(seed, element, round));
      }
    }
  }

  CHECK(seen.size() == 512);
}

TEST_CASE("random: the unit interval is filled evenly", "[property]") {
  constexpr int kCount = 40000;
  double sum = 0, sum_of_squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double u = random_unit(1, static_cast<std::uint64_t>(i));
    REQUIRE(u >= 0);
    REQUIRE(u < 1);
    sum += u;
    sum_of_squares += u * u;
  }

  // uniform: mean 1/2, second moment 1/3; five standard errors of the mean are 0.0072
  CHECK(std::abs(sum / kCount - 0.5) < 0.0072);
  CHECK(std::abs(sum_of_squares / kCount - 1.0 / 3) < 0.0075);
}

}  // namespace pbdsurg
