// SPDX-License-Identifier: Apache-2.0
#include "solver/edge_owners.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/coloring/edge_ownership.h"

namespace pbdsurg {

EdgeOwners::EdgeOwners(std::span<const Body> bodies, Index edge_count,
                       std::span<const std::array<Index, 6>> tet_edges)
    : owners_(static_cast<std::size_t>(edge_count), kInvalidIndex),
      tets_around_(find_vertex_constraints({tet_edges, edge_count})) {
  Index first_edge = 0;  // edges are sorted, so each body's are contiguous
  for (const Body& body : bodies) {
    const auto of_body = tet_edges.subspan(body.first_tet, body.tet_count);
    std::vector<std::array<Index, 6>> local(of_body.begin(), of_body.end());
    Index count = 0;
    for (auto& edges : local) {
      for (Index& edge : edges) {
        edge -= first_edge;
        count = std::max(count, edge + 1);
      }
    }
    if (has_volume_constraints(body)) {
      const EdgeOwnership ownership = assign_edges_to_tets(count, local);
      for (Index edge = 0; edge < count; ++edge) {
        owners_[first_edge + edge] = body.first_tet + ownership.owner[edge];
      }
    }
    first_edge += count;
  }
}

void EdgeOwners::hand_over(Index edge, std::span<const std::array<Index, 6>> tet_edges,
                           const ConstraintSlots<VolumeConstraint>& volumes) {
  journal_.push_back({edge, owners_[edge]});
  owners_[edge] = kInvalidIndex;
  auto fewest = std::numeric_limits<std::ptrdiff_t>::max();
  for (const Index tet : tets_around_[edge]) {
    const auto& edges = tet_edges[tet];
    const auto owned =
        std::count_if(edges.begin(), edges.end(), [&](Index e) { return (*this)[e] == tet; });
    const bool has_edge = std::ranges::find(edges, edge) != edges.end();  // it may have moved away
    if (volumes.is_alive(tet) && has_edge && owned < fewest) {
      fewest = owned;
      owners_[edge] = tet;
    }
  }
}

void EdgeOwners::undo() noexcept {
  for (; !journal_.empty(); journal_.pop_back()) {
    owners_[journal_.back().edge] = journal_.back().owner;
  }
}

}  // namespace pbdsurg
