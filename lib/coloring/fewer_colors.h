// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Fewer colours than repair finds, for constraints of some tens of conflicts each: vertex blocks.

#include <cstdint>

#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// For each constraint those that share a vertex with it, in no order. Cost: O(sum of the squares
/// of the constraints at a vertex).
[[nodiscard]] IndexLists find_conflicts(const ConstraintVertices& constraints);

/// Whether two that conflict both conflict with all of an odd ring, as the vertices of an edge with
/// an odd number of tetrahedra around it do: then no colouring has fewer than five colours, two for
/// them and three for the ring.
/// @param conflicts  of find_conflicts()
/// @return false, too, where looking on would cost more than a search
[[nodiscard]] bool has_odd_ring(const IndexLists& conflicts);

/// Empties the smallest colour by a random walk, and the next, down to the clique bound where it
/// can (color_walk.h).
///
/// The colouring stays valid and never gains a colour; where a colour cannot be emptied, it is as
/// before that was tried. Ends where has_odd_ring() leaves no hope, and after a look at a hundred
/// times as many neighbours as there are. The result depends on the arguments alone.
/// @param coloring  valid, without overflow
PBDSURG_API void find_fewer_colors(Coloring& coloring, const ConstraintVertices& constraints,
                                   std::uint64_t seed);

}  // namespace pbdsurg
