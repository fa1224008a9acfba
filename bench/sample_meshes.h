// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Connectivities of any size to colour, made without external programs.

#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/core/random.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg::bench {

struct SampleMesh {
  std::vector<Tet> tets;
  std::vector<Edge> edges;
  Index vertex_count = 0;

  [[nodiscard]] ConstraintVertices tet_constraints() const {
    return {std::span<const Tet>(tets), vertex_count};
  }
  [[nodiscard]] ConstraintVertices edge_constraints() const {
    return {std::span<const Edge>(edges), vertex_count};
  }
};

/// A box of side^3 cubes of six tetrahedra each (Kuhn): 24 tetrahedra at each inner vertex, the
/// hard case for a colouring.
inline SampleMesh lattice_mesh(Index side) {
  SampleMesh mesh;
  const auto vertex = [&](const std::array<Index, 3>& p) {
    return p[0] + (side + 1) * (p[1] + (side + 1) * p[2]);
  };
  mesh.vertex_count = (side + 1) * (side + 1) * (side + 1);
  std::array<Index, 3> cube{};
  for (cube[2] = 0; cube[2] < side; ++cube[2]) {
    for (cube[1] = 0; cube[1] < side; ++cube[1]) {
      for (cube[0] = 0; cube[0] < side; ++cube[0]) {
        std::array<int, 3> path{0, 1, 2};
        do {
          auto corner = cube;
          Tet tet{vertex(corner), 0, 0, 0};
          for (int i = 0; i < 3; ++i) {
            ++corner[path[i]];
            tet[i + 1] = vertex(corner);
          }
          mesh.tets.push_back(tet);
        } while (std::next_permutation(path.begin(), path.end()));
      }
    }
  }
  mesh.edges = find_edges(mesh.tets);
  return mesh;
}

/// A lattice whose edges are split at random, with all tetrahedra around them, until it has five
/// times as many: very irregular, a hundred tetrahedra at a vertex.
/// @param tets  how many, at least
inline SampleMesh split_mesh(Index tets) {
  Index side = 1;
  while (5 * 6 * (side + 1) * (side + 1) * (side + 1) <= tets) {
    ++side;
  }
  SampleMesh mesh = lattice_mesh(side);
  std::vector<std::vector<Index>> around(static_cast<std::size_t>(mesh.vertex_count));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) {
      around[v].push_back(static_cast<Index>(t));
    }
  }
  for (std::uint64_t split = 0; static_cast<Index>(mesh.tets.size()) < tets; ++split) {
    const Tet chosen = mesh.tets[random_bits(7, split, 0) % mesh.tets.size()];
    const auto from = random_bits(7, split, 1) % 4;
    const Index a = chosen[from];
    const Index b = chosen[(from + 1 + random_bits(7, split, 2) % 3) % 4];
    const Index middle = mesh.vertex_count++;
    around.emplace_back();
    std::vector<Index> kept_at_b;
    for (const Index t : around[b]) {
      Tet& tet = mesh.tets[t];
      if (std::find(tet.begin(), tet.end(), a) == tet.end()) {
        kept_at_b.push_back(t);
        continue;
      }
      // t keeps a; a new tetrahedron has b
      const auto added = static_cast<Index>(mesh.tets.size());
      Tet other = tet;
      std::replace(tet.begin(), tet.end(), b, middle);
      std::replace(other.begin(), other.end(), a, middle);
      around[middle].push_back(t);
      for (const Index v : other) {
        (v == b ? kept_at_b : around[v]).push_back(added);
      }
      mesh.tets.push_back(other);
    }
    around[b] = std::move(kept_at_b);
  }
  mesh.edges = find_edges(mesh.tets);
  return mesh;
}

}  // namespace pbdsurg::bench
