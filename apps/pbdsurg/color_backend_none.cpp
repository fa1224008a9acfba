// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/core/error.h"

#include "color_backend.h"

namespace pbdsurg {

Coloring color_on_gpu(const ConstraintVertices&, const ColoringOptions&) {
  throw BackendUnavailable(
      "--backend cuda: this build has no CUDA backend; configuring with PBDSURG_ENABLE_CUDA=ON, "
      "which needs the CUDA toolkit 12 or newer, would switch it on");
}

}  // namespace pbdsurg
