// SPDX-License-Identifier: Apache-2.0
#if !defined(PBDSURG_CATCH2_3)
#define CATCH_CONFIG_RUNNER
#endif
#include "tests/support/skip.h"

int main(int argc, char** argv) {
  constexpr int kSkipped = 77;  // SKIP_RETURN_CODE, and no number of failed tests
  if (Catch::Session().run(argc, argv) != 0) {
    return 1;
  }
  return pbdsurg::testing::skipped > 0 ? kSkipped : 0;
}
