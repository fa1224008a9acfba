// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The GPU's colouring, or word of why this build has none.

#include "pbdsurg/coloring/color.h"

namespace pbdsurg {

/// color_constraints() on a CUDA device, with the same result.
/// @throws BackendUnavailable  if this build or this machine has none
[[nodiscard]] Coloring color_on_gpu(const ConstraintVertices& constraints,
                                    const ColoringOptions& options);

}  // namespace pbdsurg
