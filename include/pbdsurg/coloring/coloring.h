// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colourings of constraints: no two constraints of one colour share a vertex, so those of one
/// colour can be projected in any order, or at once, without atomics.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg {

/// The vertices of constraints of one type, all of the same arity. A view: owns nothing.
struct ConstraintVertices {
  std::span<const Index> vertices;  ///< [constraint_count * arity] ids in [0, vertex_count)
  int arity = 1;
  Index vertex_count = 0;

  ConstraintVertices() = default;

  template <std::size_t kArity>
  ConstraintVertices(std::span<const std::array<Index, kArity>> constraints, Index vertices_in_use)
      : vertices(constraints.empty() ? nullptr : constraints.front().data(),
                 constraints.size() * kArity),
        arity(static_cast<int>(kArity)),
        vertex_count(vertices_in_use) {}

  [[nodiscard]] Index constraint_count() const noexcept {
    return static_cast<Index>(vertices.size() / static_cast<std::size_t>(arity));
  }
  [[nodiscard]] std::span<const Index> operator[](Index constraint) const noexcept {
    return vertices.subspan(static_cast<std::size_t>(constraint) * arity, arity);
  }
};

/// A colour for each constraint.
struct Coloring {
  std::vector<Index> color_of;  ///< [constraint_count] in [0, color_count)
  Index color_count = 0;
};

/// The most constraints at one vertex. They exclude each other pairwise, so no colouring has fewer
/// colours.
/// @throws InvalidArgument  as color_greedy()
[[nodiscard]] Index clique_bound(const ConstraintVertices& constraints);

/// First-fit colouring in the order of the constraints: each takes the lowest colour that none of
/// its vertices has seen.
///
/// No conflict graph is built: one bit mask of used colours per vertex says it all. The result
/// depends on the arguments alone. Cost: O(constraints * arity * colours / 64).
/// @throws InvalidArgument  naming the constraint whose vertex is out of range or occurs twice
[[nodiscard]] Coloring color_greedy(const ConstraintVertices& constraints);

/// Two constraints of one colour that share a vertex.
struct ColorConflict {
  Index color = kInvalidIndex;
  Index first = kInvalidIndex;   ///< constraint, the smaller of the two
  Index second = kInvalidIndex;  ///< constraint
  Index vertex = kInvalidIndex;  ///< shared by both
};

/// Checks a colouring. @return the first conflict, or nothing if the colouring is valid
/// @throws InvalidArgument  if there is not one colour in [0, color_count) for each constraint
[[nodiscard]] std::optional<ColorConflict> find_conflict(const Coloring& coloring,
                                                         const ConstraintVertices& constraints);

}  // namespace pbdsurg
