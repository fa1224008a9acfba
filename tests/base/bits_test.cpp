// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/bits.h"

#include <cstdint>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {

TEST_CASE("bits: words are counted and searched as by hand", "[property]") {
  for (std::uint64_t i = 0; i < 2000; ++i) {
    // sparse, dense and even words
    std::uint64_t word = random_bits(1, i, 0);
    word = i % 3 == 0   ? word & random_bits(1, i, 1) & random_bits(1, i, 2)
           : i % 3 == 1 ? word | random_bits(1, i, 1) | random_bits(1, i, 2)
                        : word;
    int rank = 0;
    for (int at = 0; at < 64; ++at) {
      if (((word >> at) & 1) != 0) {
        REQUIRE(nth_bit(word, rank) == at);
        if (rank == 0) {
          REQUIRE(lowest_bit(word) == at);
        }
        ++rank;
      }
    }
    REQUIRE(count_bits(word) == rank);
  }
}

TEST_CASE("bits: full and empty words", "[unit]") {
  CHECK(count_bits(0) == 0);
  CHECK(count_bits(~std::uint64_t{0}) == 64);
  CHECK(nth_bit(~std::uint64_t{0}, 63) == 63);
  CHECK(low_bits(0) == 0);
  CHECK(low_bits(3) == 7);
  CHECK(low_bits(64) == ~std::uint64_t{0});
}

}  // namespace pbdsurg
