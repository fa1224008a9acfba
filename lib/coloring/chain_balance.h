// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What balancing does on the host, whatever device has swept, where the sweeps leave colours
/// uneven.

#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Whether the root mean square of the distances of the sizes from the two whole numbers around
/// their mean is at most 2 % of it. So it is where the relative deviation is at most 2 %.
[[nodiscard]] PBDSURG_API bool is_even(const std::vector<Index>& sizes);

/// Moves constraints from colours above the mean size to those below it by Kempe chains: those of
/// two colours that hang together exchange the two colours. In the order of the constraints, so
/// that those near one another move to one colour, which then has few gaps there: sweeps at random
/// end where no single one is free to move and two thirds of a colour are there.
///
/// Cost: at most four sweeps of O(colours below the mean * arity * length of chains) for each
/// constraint of a colour above it, with chains of about 5, 10, 20 and 40; memory as
/// repair_coloring(), and 8 bytes a constraint.
/// @param coloring  valid; overflow stays where it is
void balance_by_chains(Coloring& coloring, const ConstraintVertices& constraints);

/// What balance_coloring() results in where is_even() does not hold of the sweeps' sizes.
/// @param given  before the sweeps
/// @param swept  after them, without gaps
/// @return swept if it has fewer colours; otherwise the more even of it and of what chains make of
///         `given`
[[nodiscard]] PBDSURG_API Coloring more_even_coloring(Coloring given, Coloring swept,
                                                      const ConstraintVertices& constraints);

}  // namespace pbdsurg
