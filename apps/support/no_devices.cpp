// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"

#include "apps/support/executors.h"

namespace pbdsurg::programs {

Executor device(int /*ordinal*/) {
  throw BackendUnavailable("there is no CUDA device: this build has no CUDA");
}

Executor best() {
  return executor::threads();
}

}  // namespace pbdsurg::programs
