// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/cuda/device.h"

#include "apps/support/executors.h"

namespace pbdsurg::programs {

Executor device(int ordinal) {
  return cuda::device(ordinal);
}

Executor best() {
  return cuda::best();
}

}  // namespace pbdsurg::programs
