// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edits that part tissue and split it, for tests.

#include <algorithm>
#include <cstdint>
#include <span>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

inline bool has_corner(const Tet& tet, Index vertex) {
  return std::ranges::find(tet, vertex) != tet.end();
}

/// Some of the tetrahedra at a vertex, and links there, go with a copy of it.
inline TopologyEdit part_vertex(const Solver& solver, Index vertex, std::uint64_t seed) {
  TopologyEdit edit;
  const Index copy = solver.vertex_count();
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    if (solver.tissue().is_tet_alive(t) && has_corner(solver.tissue().tets()[t], vertex) &&
        (edit.corner_moves.empty() || random_bits(seed, t) % 2 == 0)) {
      edit.corner_moves.push_back({t, vertex, copy});
    }
  }
  if (edit.corner_moves.empty()) {
    return {};
  }
  edit.new_vertices.push_back({vertex, vertex});
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    const Link& link = solver.tissue().links()[l];
    if (solver.tissue().is_link_alive(l) && (link.first == vertex || link.second == vertex) &&
        random_bits(seed, l, 1) % 2 == 0) {
      edit.link_moves.push_back({l, vertex, copy});
    }
  }
  return edit;
}

/// Half of the triangles at a vertex of a sheet go with a copy of it.
inline TopologyEdit rip_vertex(const Solver& solver, Index vertex) {
  const std::span<const Index> triangles = solver.tissue().triangles_at(vertex);
  if (triangles.size() < 2) {
    return {};
  }
  TopologyEdit edit{.new_vertices = {{vertex, vertex}}};
  for (const Index t : triangles.first(triangles.size() / 2)) {
    edit.triangle_moves.push_back({t, vertex, solver.vertex_count()});
  }
  return edit;
}

/// A new vertex halves an edge, or nearly, and all tetrahedra around it.
inline TopologyEdit split_edge(const Solver& solver, Index edge, float share) {
  TopologyEdit edit;
  const Index middle = solver.vertex_count();
  const auto [a, b] = solver.tissue().edges()[edge];
  edit.new_vertices.push_back({a, b, share});
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    const Tet& tet = solver.tissue().tets()[t];
    if (!solver.tissue().is_tet_alive(t) || !has_corner(tet, a) || !has_corner(tet, b)) {
      continue;
    }
    for (const Index gone : {a, b}) {
      NewTet part{t, tet};
      std::ranges::replace(part.vertices, gone, middle);
      edit.new_tets.push_back(part);
    }
  }
  return edit;
}

/// Halves an edge here, or parts tissue at a vertex there.
/// @param solver  of a body with some hundred vertices at least
inline TopologyEdit small_cut(const Solver& solver, std::uint64_t round) {
  const auto vertex = static_cast<Index>(random_bits(3, round) % 300);
  auto edge = static_cast<Index>(random_bits(4, round) % 1000);
  while (!solver.tissue().is_edge_alive(edge)) {
    ++edge;
  }
  return round % 2 == 0 ? split_edge(solver, edge, 0.4F) : part_vertex(solver, vertex, round);
}

}  // namespace pbdsurg::testing
