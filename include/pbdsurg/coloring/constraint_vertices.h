// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is to be coloured: constraints and the vertices that each touches.
///
/// Two constraints conflict when they share a vertex. That is all that a colouring needs to know,
/// so the conflict graph, with its 70 to 100 neighbours per tetrahedron, is never built.

#include <array>
#include <cstddef>
#include <span>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {

/// The vertices of constraints. A view: owns nothing.
///
/// Fixed arity (edges, tetrahedra; nothing at all by default) when `arity` is positive; otherwise
/// constraint c touches vertices[offsets[c] .. offsets[c + 1]), of any number (clusters, vertex
/// blocks).
struct ConstraintVertices {
  std::span<const Index> vertices;  ///< ids in [0, vertex_count), constraint by constraint
  std::span<const Index> offsets;   ///< [constraint_count + 1], empty for fixed arity
  int arity = 1;                    ///< 0 where `offsets` says
  Index vertex_count = 0;           ///< of the mesh, those that no constraint touches included

  ConstraintVertices() = default;

  /// Constraints of fixed arity.
  /// @param constraints  [constraint_count]
  template <std::size_t kArity>
  ConstraintVertices(std::span<const std::array<Index, kArity>> constraints, Index vertices_in_use)
      : vertices(constraints.empty() ? nullptr : constraints.front().data(),
                 constraints.size() * kArity),
        arity(static_cast<int>(kArity)),
        vertex_count(vertices_in_use) {
    static_assert(kArity > 0);
  }

  /// Constraints of any arity; the lists must outlive the view.
  ConstraintVertices(const IndexLists& lists, Index vertices_in_use)
      : vertices(lists.entries), offsets(lists.offsets), arity(0), vertex_count(vertices_in_use) {}

  /// How many constraints there are.
  [[nodiscard]] Index constraint_count() const noexcept {
    return arity == 0 ? static_cast<Index>(offsets.size()) - 1
                      : static_cast<Index>(vertices.size() / static_cast<std::size_t>(arity));
  }
  /// @param constraint  in [0, constraint_count()), which is not checked
  [[nodiscard]] std::span<const Index> operator[](Index constraint) const noexcept {
    const auto at = static_cast<std::size_t>(constraint);
    if (arity == 0) {
      const auto begin = static_cast<std::size_t>(offsets[at]);
      return vertices.subspan(begin, static_cast<std::size_t>(offsets[at + 1]) - begin);
    }
    const auto corners = static_cast<std::size_t>(arity);
    return vertices.subspan(at * corners, corners);
  }
};

/// Refuses what cannot be coloured. Everything that takes ConstraintVertices calls it first.
/// Cost: O(vertices named).
/// @throws InvalidArgument  naming the constraint whose vertex is out of range or occurs twice
PBDSURG_API void check_constraints(const ConstraintVertices& constraints);

/// The most constraints at one vertex. They exclude each other pairwise, so no colouring has fewer
/// colours.
/// @throws InvalidArgument  as check_constraints()
[[nodiscard]] PBDSURG_API Index clique_bound(const ConstraintVertices& constraints);

/// For each vertex, the constraints that touch it, ascending. Cost: O(V + vertices named).
///
/// Read the other way round, these are vertex blocks: a solver that moves one vertex at a time
/// against all its constraints colours ConstraintVertices(lists, constraints.constraint_count()),
/// in which two vertices conflict when a constraint joins them.
/// @throws InvalidArgument  as check_constraints()
[[nodiscard]] PBDSURG_API IndexLists find_vertex_constraints(const ConstraintVertices& constraints);

}  // namespace pbdsurg
