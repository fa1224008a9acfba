// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edit_trial.h"

#include <cstdint>
#include <string>

#include "pbdsurg/cuda/device.h"

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a device that misses anything of an edit or its undo, or whose step feels one that
// comes within it: stream, graph and cluster in turn, each state that of the serial backend, bit
// for bit.
TEST_CASE("cuda edits: any edits leave the serial bits", "[device]") {
  constexpr std::uint64_t kTrials = 300;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const std::string wrong =
        testing::run_edit_trial(testing::bytes_of_trial(seed), cuda::device());
    INFO("seed " << seed);
    REQUIRE(wrong == "");
  }
}

}  // namespace pbdsurg
