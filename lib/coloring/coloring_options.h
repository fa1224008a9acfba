// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every backend refuses and understands alike.

#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/coloring/repair.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option out of range
PBDSURG_API void check_coloring_options(const ColoringOptions& options);

/// First fit packs the lower colours so that its repair ends near the clique bound. Random draws
/// leave every colour as full as the others, so that the last constraints find swaps with one alone
/// blocked.
inline RepairSwaps repair_swaps(const ColoringOptions& options) {
  return options.algorithm == ColoringAlgorithm::random_disc ? RepairSwaps::with_two
                                                             : RepairSwaps::with_one;
}

}  // namespace pbdsurg
