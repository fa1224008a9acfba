// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Joint constraints: tetrahedra that project their edges themselves.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Each edge is owned by one of the tetrahedra around it, which projects its distance constraint
/// together with its own volume constraint. A colouring of the tetrahedra then serves both kinds:
/// as many phases as tetrahedra need, in place of theirs and those of the edges.
struct EdgeOwnership {
  std::vector<Index> owner;               ///< [edge_count] tetrahedron
  std::vector<std::uint8_t> owned_edges;  ///< [tet_count] bit i: owns edge i of kTetEdges
  int max_owned = 0;                      ///< most edges of one tetrahedron, at most 6
};

/// Shares edges out so that the largest number owned by one tetrahedron is as small as possible,
/// because a phase lasts as long as its busiest constraint. It is a matching of edges to
/// tetrahedra: greedy at first, then improved along shortest augmenting paths, phase by phase
/// (Hopcroft, Karp 1973; Dinic 1970).
///
/// The result depends on the arguments alone. Cost: O(T) for each phase of paths, of which meshes
/// take a few (0.1 s for a million tetrahedra).
/// @param edge_count  edges are [0, edge_count)
/// @param tet_edges   [tet_count] from find_tet_edges()
/// @throws InvalidArgument  naming the tetrahedron whose edge is out of range or occurs twice, or
///                          the edge that no tetrahedron has
[[nodiscard]] PBDSURG_API EdgeOwnership
assign_edges_to_tets(Index edge_count, std::span<const std::array<Index, 6>> tet_edges);

}  // namespace pbdsurg
