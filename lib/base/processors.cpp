// SPDX-License-Identifier: Apache-2.0
#include "lib/base/processors.h"

#include <algorithm>
#include <thread>

#include <sched.h>

namespace pbdsurg {

int processor_count() noexcept {
  cpu_set_t processors;  // of the first 1024
  if (sched_getaffinity(0, sizeof processors, &processors) == 0) {
    return std::max(1, CPU_COUNT(&processors));
  }
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace pbdsurg
