// SPDX-License-Identifier: Apache-2.0
// With --needs-device first: leaves with code 77, which ctest shows as skipped, if there is none.
#include <cstdio>
#include <string_view>

#include "pbdsurg/cuda/device.h"

#if !defined(PBDSURG_CATCH2_3)
#define CATCH_CONFIG_RUNNER
#endif
#include "tests/support/catch.h"

int main(int argc, char** argv) {
  constexpr int kSkipped = 77;
  if (argc > 1 && std::string_view(argv[1]) == "--needs-device") {
    const pbdsurg::cuda::DeviceList list = pbdsurg::cuda::find_devices();
    if (list.devices.empty()) {
      std::printf("skipped: %s\n", list.reason.c_str());
      return kSkipped;
    }
    argv[1] = argv[0];
    --argc;
    ++argv;
  }
  return Catch::Session().run(argc, argv);
}
