// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Clusters of constraints: projected one after another inside, in parallel with clusters of the
/// same colour.

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// Groups of constraints, and what to colour them by.
struct ConstraintClusters {
  IndexLists members;   ///< [cluster_count] constraints of each, in the order of projection
  IndexLists vertices;  ///< [cluster_count] vertices of each, ascending; colour these
};

/// Groups constraints into compact clusters that share many vertices: fewer, fatter conflicts, so
/// fewer colours (Ton-That, Kry, Andrews 2022). Where tetrahedra take 97 colours, clusters of 2, 4,
/// 8 and 16 take 59, 37, 20 and 15 (row 2 of table 2, surface_filled); where they take 34, it is
/// 20, 14, 12 and 9 (hollow).
///
/// Greedy: while a cluster has room, it takes the neighbour that adds the fewest vertices; among
/// equals, the one with the fewest ungrouped constraints around it, then the lowest. The next
/// cluster starts beside it, by the last two rules, or at the lowest constraint left.
///
/// Colour ConstraintVertices(clusters.vertices, constraints.vertex_count). The result depends on
/// the arguments alone. Cost: O(size * constraints at a vertex) for each constraint (0.5 s for a
/// million tetrahedra and sizes up to 16).
/// @param size  most constraints in a cluster, >= 1; 2 to 16 are useful
/// @throws InvalidArgument  as check_constraints(), or if size is out of range
[[nodiscard]] PBDSURG_API ConstraintClusters
cluster_constraints(const ConstraintVertices& constraints, Index size);

}  // namespace pbdsurg
