// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/cuda/coloring.h"

#include "color_backend.h"

namespace pbdsurg {

Coloring color_on_gpu(const ConstraintVertices& constraints, const ColoringOptions& options) {
  return cuda::color_constraints(constraints, options);
}

}  // namespace pbdsurg
