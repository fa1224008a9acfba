// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Divides the vertices of a mesh into parts of equal size with few edges between them, one part
/// for each block or thread that will hold them.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// How vertices are divided.
enum class PartitionMethod {
  best,                 ///< metis where this build has it, else recursive_bisection
  metis,                ///< multilevel k-way (Karypis and Kumar 1998): fewest cut edges
  recursive_bisection,  ///< halves along the longest side of the box: the same on every machine
};

/// A division of vertices.
struct Partition {
  Index part_count = 0;               ///< none of them empty
  std::vector<Index> part_of_vertex;  ///< [vertex_count] in [0, part_count)
  Index cut_edges = 0;                ///< edges that join two parts
  std::string_view method;            ///< what made it: "metis" or "recursive bisection"
};

/// Divides vertices into part_count parts, none of them empty.
///
/// Bisection gives sizes that differ by at most one. METIS keeps every part within 3 % above the
/// mean, rounded up to a whole vertex; where it cannot (parts of a few vertices, a graph without
/// edges) bisection is used instead, and `method` says so. The same input gives the same parts;
/// for METIS that holds for one version of its library.
///
/// @param edges       [edge_count] pairs of vertex ids; repeated pairs count once for METIS
/// @param positions   [vertex_count] m, finite
/// @param part_count  in [1, vertex_count]
/// @param seed        for METIS; bisection uses no randomness
/// @throws InvalidArgument     naming the edge, vertex or count that breaks one of these rules
/// @throws BackendUnavailable  if METIS is asked for by name in a build without it
/// Cost: O(E log E) for METIS, O(V log P) for bisection. METIS uses the C library's rand(), so
/// calls to it take turns and its state changes.
[[nodiscard]] PBDSURG_API Partition partition_vertices(
    std::span<const Edge> edges, std::span<const Eigen::Vector3d> positions, Index part_count,
    PartitionMethod method = PartitionMethod::best, std::uint64_t seed = 0);

/// Whether this build of the library can use METIS.
[[nodiscard]] PBDSURG_API bool has_metis() noexcept;

}  // namespace pbdsurg
