// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// First fit along an order, by one thread.

#include <span>

#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// @param constraints  checked
/// @param order        [constraint_count] constraints, first to last; empty for the natural order
[[nodiscard]] Coloring first_fit(const ConstraintVertices& constraints,
                                 std::span<const Index> order = {});

}  // namespace pbdsurg
