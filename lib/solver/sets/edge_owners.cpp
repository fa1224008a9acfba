// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/edge_owners.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/coloring/edge_ownership.h"

namespace pbdsurg {

EdgeOwners::EdgeOwners(std::span<const Body> bodies, Index edge_count,
                       std::span<const std::array<Index, 6>> tet_edges)
    : tets_around_(find_vertex_constraints({tet_edges, edge_count})) {
  std::vector<Index> owners(static_cast<std::size_t>(edge_count), kInvalidIndex);
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
        owners[first_edge + edge] = body.first_tet + ownership.owner[edge];
      }
    }
    first_edge += count;
  }
  owners_ = UndoArray(std::move(owners));
}

}  // namespace pbdsurg
