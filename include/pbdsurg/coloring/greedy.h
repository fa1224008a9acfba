// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// First-fit colouring: constraint by constraint, each takes the lowest colour that none of its
/// vertices has seen.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Which constraint is coloured next.
enum class GreedyOrder : std::uint8_t {
  natural,          ///< as given: the mesher's order, kind to caches
  largest_valence,  ///< most constraints at one of its vertices first, then most at all of them
  /// Last comes the one with the fewest conflicts, then the one with the fewest among the rest, and
  /// so on (Matula, Beck 1983). Conflicts count once per shared vertex.
  smallest_last,
  /// Most colours forbidden first (DSATUR, Brelaz 1979); of the first 64 such, most conflicts.
  saturation,
};

/// First fit. The result depends on the arguments alone.
///
/// A 64-bit mask of used colours per vertex says what is forbidden; constraints that find 64
/// colours taken wait for the next 64, which changes nothing in the outcome.
///
/// Cost: O(vertices named) for `natural` and `largest_valence` (30 and 300 ns a tetrahedron at a
/// million); with v constraints at a vertex, O(v) times as much for the other two.
/// @throws InvalidArgument  as check_constraints()
[[nodiscard]] PBDSURG_API Coloring color_greedy(const ConstraintVertices& constraints,
                                                GreedyOrder order = GreedyOrder::natural);

}  // namespace pbdsurg
