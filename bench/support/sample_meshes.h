// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Connectivities of any size to colour, made without external programs.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg::bench {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(seed) {}
  Index below(std::size_t count) { return static_cast<Index>(random_bits(seed_, next_++) % count); }

 private:
  std::uint64_t seed_;
  std::uint64_t next_ = 0;
};

struct Tets {
  std::vector<Tet> tets;
  Index vertex_count = 0;

  [[nodiscard]] ConstraintVertices view() const { return view(tets); }
  [[nodiscard]] ConstraintVertices view(const std::vector<Tet>& some) const {
    return {std::span<const Tet>(some), vertex_count};
  }
};

/// Splits edges, with all tetrahedra around them.
class Splitter {
 public:
  explicit Splitter(Tets mesh)
      : mesh_(std::move(mesh)), around_(static_cast<std::size_t>(mesh_.vertex_count)) {
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      for (const Index v : mesh_.tets[t]) {
        around_[v].push_back(static_cast<Index>(t));
      }
    }
  }

  [[nodiscard]] const Tets& mesh() const { return mesh_; }

  /// Splits an edge of a tetrahedron: those around it keep one end and take the middle for the
  /// other, which added ones have.
  void split(Index chosen, Dice& dice) {
    const Tet& corners = mesh_.tets[chosen];
    const Index from = dice.below(4);
    const Index a = corners[from];
    const Index b = corners[(from + 1 + dice.below(3)) % 4];
    const Index middle = mesh_.vertex_count++;
    around_.emplace_back();
    std::vector<Index> at_b;
    for (const Index t : around_[b]) {
      Tet& tet = mesh_.tets[t];
      if (std::find(tet.begin(), tet.end(), a) == tet.end()) {
        at_b.push_back(t);
        continue;
      }
      const auto added = static_cast<Index>(mesh_.tets.size());
      Tet other = tet;
      std::replace(tet.begin(), tet.end(), b, middle);
      std::replace(other.begin(), other.end(), a, middle);
      around_[middle].push_back(t);
      for (const Index v : other) {
        (v == b ? at_b : around_[v]).push_back(added);
      }
      mesh_.tets.push_back(other);
    }
    around_[b] = std::move(at_b);
  }

 private:
  Tets mesh_;
  std::vector<std::vector<Index>> around_;  // [vertex_count] tetrahedra
};

/// A box of side^3 cubes of six tetrahedra each (Kuhn): 24 tetrahedra at each inner vertex, the
/// hard case for a colouring.
inline Tets lattice_mesh(Index side) {
  Tets mesh;
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
  return mesh;
}

/// Such a box whose edges are split at random until it has five times as many tetrahedra: very
/// irregular, a hundred tetrahedra at a vertex.
/// @param wanted  tetrahedra, at least
inline Tets split_mesh(Index wanted) {
  Index side = 1;
  while (5 * 6 * (side + 1) * (side + 1) * (side + 1) <= wanted) {
    ++side;
  }
  Splitter splitter(lattice_mesh(side));
  Dice dice(7);
  while (static_cast<Index>(splitter.mesh().tets.size()) < wanted) {
    splitter.split(dice.below(splitter.mesh().tets.size()), dice);
  }
  return splitter.mesh();
}

}  // namespace pbdsurg::bench
