// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colours of equal size.

#include <cstdint>

#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Moves constraints from colours above the mean size to free ones below it, without an extra
/// colour (guided shuffle: Lu et al. 2017, "Algorithms for balanced graph colorings"). In rounds:
/// constraints of a colour volunteer with the probability that would bring it to the mean, draw a
/// free colour below the mean, and move unless a neighbour of larger random rank drew the same.
///
/// The colouring stays valid and no colour becomes empty. The result depends on the arguments other
/// than threads alone. Cost: 5 to 30 rounds, each over the colours above the mean.
/// @param coloring  valid; overflow stays where it is
/// @param threads   >= 1, or 0 for one a processor
/// @throws InvalidArgument  as find_conflict() and check_constraints(), if the colouring is not
///                          valid, or if threads is negative; then nothing has changed
void balance_coloring(Coloring& coloring, const ConstraintVertices& constraints,
                      std::uint64_t seed = 0, int threads = 1);

}  // namespace pbdsurg
