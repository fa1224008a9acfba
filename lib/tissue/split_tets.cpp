// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/split_tets.h"

#include <Eigen/LU>
#include <algorithm>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/removal.h"

namespace pbdsurg {
namespace {

// kInvalidIndex if no live tetrahedron has it.
Index find_live_edge(const TissueData& data, Index a, Index b) {
  for (const Index tet : data.vertex_tets[a]) {
    for (const Index edge : data.tet_edges[tet]) {
      if (data.edges[edge] == Edge{std::min(a, b), std::max(a, b)}) {
        return edge;
      }
    }
  }
  return kInvalidIndex;
}

void add_part(TissueData& data, const NewTet& tet, double share) {
  const Index id =
      data.add_tet(tet.vertices, data.body_of_tet(tet.parent), share * data.tet_masses[tet.parent],
                   data.stiffnesses[tet.parent], data.fibres[tet.parent]);
  TetEdges edges;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    const Index a = tet.vertices[i], b = tet.vertices[j];
    edges[e] = find_live_edge(data, a, b);
    if (edges[e] == kInvalidIndex) {
      edges[e] = data.add_edge({std::min(a, b), std::max(a, b)});
    }
    data.edge_tets.set(edges[e], data.edge_tets[edges[e]] + 1);
  }
  data.set_tet(id, tet.vertices, edges);
  for (const Index v : tet.vertices) {
    data.vertex_tets.insert(v, id);
    data.buffer.push_back(v);
  }
}

}  // namespace

Eigen::Matrix3d sides_of(const Shares& shares) {
  Eigen::Matrix3d sides;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      sides(i, k) = shares[k + 1][i + 1] - shares[0][i + 1];
    }
  }
  return sides;
}

std::optional<Shares> find_shares(const Tet& corners, const TopologyEdit& edit, const NewTet& tet,
                                  Index first_new_vertex) {
  Shares shares{};
  const auto add = [&](std::size_t k, Index vertex, double share) {
    const auto corner = std::ranges::find(corners, vertex) - corners.begin();
    if (corner == 4) {
      return false;
    }
    shares[k][corner] += share;
    return true;
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const Index v = tet.vertices[k];
    bool is_found = false;
    if (v >= first_new_vertex) {
      const NewVertex& vertex = edit.new_vertices[v - first_new_vertex];
      is_found = add(k, vertex.first, 1 - double{vertex.share}) &&
                 add(k, vertex.second, double{vertex.share});
    } else {
      is_found = add(k, v, 1);
    }
    if (!is_found) {
      return std::nullopt;
    }
  }
  return shares;
}

double volume_share(const Shares& shares) {
  return sides_of(shares).determinant();
}

void replace_parents(TissueData& data, const TopologyEdit& edit) {
  for (const NewTet& tet : edit.new_tets) {
    const Shares shares =
        *find_shares(data.tets[tet.parent], edit, tet, data.change.first_new_vertex);
    add_part(data, tet, volume_share(shares));
  }
  data.change.first_removed_parent = static_cast<Index>(data.change.removed_tets.size());
  for (const NewTet& tet : edit.new_tets) {
    if (data.tet_alive[tet.parent] != 0) {
      take_out_tet(data, tet.parent);
    }
  }
}

}  // namespace pbdsurg
