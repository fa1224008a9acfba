// SPDX-License-Identifier: Apache-2.0
// Edits made of bytes: see support/edit_trial.h. Ends the program at the first thing that is wrong.
// PBDSURG_TRIAL_EXECUTOR is who steps.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "apps/support/executors.h"
#include "tests/support/edit_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pbdsurg::testing::run_edit_trial(
      {data, size}, pbdsurg::programs::executor_named(PBDSURG_TRIAL_EXECUTOR));
  if (!wrong.empty()) {
    std::fprintf(stderr, "%s\n", wrong.c_str());
    std::abort();
  }
  return 0;
}
