// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which tetrahedron projects an edge, in a joint plan.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/scene.h"

#include "lib/solver/sets/constraint_slots.h"

namespace pbdsurg {

/// Whether a body's tetrahedra have volume constraints.
inline bool has_volume_constraints(const Body& body) noexcept {
  return body.material.model == ElasticModel::springs && body.material.has_volume_constraints;
}

/// Each live edge of a body with volume constraints is owned by a live tetrahedron around it; other
/// edges have no owner, nor do those that came with edits, or have only tetrahedra that did. Made
/// by default, it is that of a separate plan: no edge has one.
class EdgeOwners {
 public:
  EdgeOwners() = default;

  /// Shares the edges of each body with volume constraints out among its tetrahedra.
  /// @param tet_edges  [tet_count] of all bodies
  EdgeOwners(std::span<const Body> bodies, Index edge_count,
             std::span<const std::array<Index, 6>> tet_edges);

  /// Tetrahedron, or kInvalidIndex.
  [[nodiscard]] Index operator[](Index edge) const noexcept {
    return edge < owners_.size() ? owners_[edge] : kInvalidIndex;
  }

  /// Gives a live edge to the live tetrahedron around it that owns fewest edges, because a phase
  /// lasts as long as its busiest tetrahedron; to none if there is none of the scene any more.
  /// Cost: proportional to the tetrahedra around it.
  /// @param edges_of  std::span<const Index, 6>(Index tet)
  /// @param volumes   those of live tetrahedra
  template <class EdgesOf>
  void hand_over(Index edge, const EdgesOf& edges_of,
                 const ConstraintSlots<VolumeConstraint>& volumes);

  /// Forgets what was handed over so far.
  void begin_edit() noexcept { owners_.begin_edit(); }

  /// Takes back all that was handed over since begin_edit().
  void undo() { owners_.undo(); }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return owners_.memory_bytes() +
           (tets_around_.offsets.capacity() + tets_around_.entries.capacity()) * sizeof(Index);
  }

 private:
  UndoArray<Index> owners_;  // [edge_count]
  IndexLists tets_around_;   // [edge_count] all that there ever were
};

template <class EdgesOf>
void EdgeOwners::hand_over(Index edge, const EdgesOf& edges_of,
                           const ConstraintSlots<VolumeConstraint>& volumes) {
  owners_.set(edge, kInvalidIndex);
  auto fewest = std::numeric_limits<std::ptrdiff_t>::max();
  for (const Index tet : tets_around_[edge]) {
    const std::span<const Index, 6> edges = edges_of(tet);
    const auto owned = std::ranges::count_if(edges, [&](Index e) { return (*this)[e] == tet; });
    const bool has_edge = std::ranges::find(edges, edge) != edges.end();  // it may have moved away
    if (volumes.is_alive(tet) && has_edge && owned < fewest) {
      fewest = owned;
      owners_.set(edge, tet);
    }
  }
}

}  // namespace pbdsurg
