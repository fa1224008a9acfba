// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What follows from the connectivity of tetrahedra: edges, surface, adjacency, components.

#include <array>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Lists of varying length in two flat arrays (compressed rows).
struct IndexLists {
  std::vector<Index> offsets{0};  ///< [list_count + 1] first entry of each list
  std::vector<Index> entries;     ///< [offsets.back()]

  /// How many lists there are.
  [[nodiscard]] Index list_count() const noexcept { return static_cast<Index>(offsets.size()) - 1; }
  /// The entries of one list.
  /// @param list  in [0, list_count()), which is not checked
  [[nodiscard]] std::span<const Index> operator[](Index list) const noexcept {
    const auto at = static_cast<std::size_t>(list);
    return {entries.data() + offsets[at], entries.data() + offsets[at + 1]};
  }
};

/// A boundary triangle and where it comes from.
struct BoundaryTriangle {
  Triangle vertices;  ///< wound so that the normal points out of the tetrahedron
  Index tet;          ///< the tetrahedron it bounds
};

/// The four triangles of a tetrahedron, wound outwards; triangle i lies opposite to vertex i.
inline constexpr std::array<std::array<int, 3>, 4> kTetTriangles{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// The six edges of a tetrahedron; edges i and 5 - i are opposite.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Unique edges, each with its smaller id first, sorted. Cost: O(T log T).
[[nodiscard]] PBDSURG_API std::vector<Edge> find_edges(std::span<const Tet> tets);

/// Where the edge between two vertices stands in a list from find_edges(). Cost: O(log E).
/// @throws InvalidArgument  naming the edge that is not there
[[nodiscard]] PBDSURG_API Index find_edge(std::span<const Edge> edges, Index a, Index b);

/// The six edges of each tetrahedron, in the order of kTetEdges.
/// @param edges  from find_edges() of the same tetrahedra
/// @throws InvalidArgument  as find_edge()
[[nodiscard]] PBDSURG_API std::vector<std::array<Index, 6>> find_tet_edges(
    std::span<const Tet> tets, std::span<const Edge> edges);

/// Triangles that belong to exactly one tetrahedron, in the order of the tetrahedra.
/// Cost: O(T log T).
[[nodiscard]] PBDSURG_API std::vector<BoundaryTriangle> find_boundary(std::span<const Tet> tets);

/// For each vertex, the tetrahedra that use it, ascending. Cost: O(V + T).
/// @throws InvalidArgument  naming the vertex out of [0, vertex_count), or that count if negative
[[nodiscard]] PBDSURG_API IndexLists find_vertex_tets(Index vertex_count,
                                                      std::span<const Tet> tets);

/// Connected parts, joined through shared vertices.
struct Components {
  Index count = 0;               ///< how many parts there are
  std::vector<Index> of_vertex;  ///< [vertex_count] component, kInvalidIndex for an unused vertex
};

/// Finds the connected parts of tetrahedra, numbered by their smallest vertex. Cost: O(V + T).
/// @throws InvalidArgument  as find_vertex_tets()
[[nodiscard]] PBDSURG_API Components find_components(Index vertex_count, std::span<const Tet> tets);

/// Same for triangles.
[[nodiscard]] PBDSURG_API Components find_components(Index vertex_count,
                                                     std::span<const Triangle> triangles);

}  // namespace pbdsurg
