// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/noise_volumes.h"

#include <algorithm>
#include <cstdlib>

#include "tests/support/catch.h"

namespace cholecystectomy {

// Would catch a seam: across the border, values change no faster than inside.
TEST_CASE("noise: the volumes repeat without a seam", "[property]") {
  const bool cells = GENERATE(false, true);
  const std::vector<std::uint8_t> texels = cells ? make_cell_noise() : make_gradient_noise();
  REQUIRE(texels.size() == 4u * kNoiseSize * kNoiseSize * kNoiseSize);
  const auto value = [&](int x, int y, int z) {
    const int n = kNoiseSize;
    return static_cast<int>(
        texels[4 * static_cast<std::size_t>(((z % n) * n + y % n) * n + x % n) + 3]);
  };

  int largest_inside = 0, largest_across = 0;
  for (int a = 0; a < kNoiseSize; ++a) {
    for (int b = 0; b < kNoiseSize; ++b) {
      for (int step = 0; step < kNoiseSize; ++step) {
        int& largest = step == kNoiseSize - 1 ? largest_across : largest_inside;
        largest = std::max(largest, std::abs(value(step, a, b) - value(step + 1, a, b)));
        largest = std::max(largest, std::abs(value(a, b, step) - value(a, b, step + 1)));
      }
    }
  }

  CHECK(largest_inside > 8);  // not a flat volume
  CHECK(largest_across <= largest_inside);
}

}  // namespace cholecystectomy
