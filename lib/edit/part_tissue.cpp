// SPDX-License-Identifier: Apache-2.0
#include "edit/part_tissue.h"

#include <algorithm>
#include <memory_resource>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "edit/removal.h"
#include "solver/growth.h"

namespace pbdsurg {
namespace {

// A tetrahedron that had an edge before corners moved, and the edge's place in kTetEdges.
struct EdgeUse {
  Index edge, tet, place;
};

// Edges, and after which edge they go.
using AddedEdges = std::pmr::vector<std::pair<Index, EdgeNumbers>>;

// Of all edges at corners that move: every tetrahedron around them, ascending.
std::pmr::vector<EdgeUse> find_uses(const SolverData& data, const TopologyEdit& edit) {
  std::pmr::vector<Index> edges(data.scratch.get());
  for (const CornerMove& move : edit.corner_moves) {
    for (const Index edge : data.tet_edges[move.tet]) {
      if (data.edges[edge][0] == move.from || data.edges[edge][1] == move.from) {
        edges.push_back(edge);
      }
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::pmr::vector<EdgeUse> uses(data.scratch.get());
  for (const Index edge : edges) {
    for (const Index tet : data.vertex_tets[data.edges[edge][0]]) {
      const auto& of_tet = data.tet_edges[tet];
      const auto place = std::ranges::find(of_tet, edge) - of_tet.begin();
      if (place < 6) {
        uses.push_back({edge, tet, static_cast<Index>(place)});
      }
    }
  }
  return uses;
}

void move_corner(SolverData& data, const CornerMove& move, EditResult& result) {
  Tet vertices = data.tets[move.tet];
  std::ranges::replace(vertices, move.from, move.to);
  data.set_tet(move.tet, vertices, data.tet_edges[move.tet]);
  data.log_tet(move.tet);
  data.add_tet_at(move.to, move.tet);
  take_from_vertex(data, move.from, move.tet, result);
  const Tet places = data.places_of(vertices);
  if (data.volumes.is_alive(move.tet)) {
    data.volumes.set_places(move.tet, places);
    data.log_constraint(PhaseKind::volume, move.tet);
  }
  if (data.neo_hookeans.is_alive(move.tet)) {
    data.neo_hookeans.set_places(move.tet, places);
    data.log_constraint(PhaseKind::neo_hookean, move.tet);
  }
}

Edge ends_of(const SolverData& data, const EdgeUse& use) {
  const Index a = data.tets[use.tet][kTetEdges[use.place][0]];
  const Index b = data.tets[use.tet][kTetEdges[use.place][1]];
  return {std::min(a, b), std::max(a, b)};
}

void point_edge(SolverData& data, Index edge, const Edge& ends) {
  data.set_edge(edge, ends);
  const Index distance = data.distance_ids.of_edge(edge);
  if (data.distances.is_alive(distance)) {
    data.distances.set_places(distance, data.places_of(ends));
    data.log_constraint(PhaseKind::distance, distance);
  }
  if (data.strain_limits.is_alive(edge)) {
    data.strain_limits.set_places(edge, data.places_of(ends));
    data.log_constraint(PhaseKind::strain_limit, edge);
  }
}

// Gives those that have an edge together no longer edges of their own.
// @param uses  of one edge
void part_edge(SolverData& data, std::span<const EdgeUse> uses, AddedEdges& added) {
  const Index edge = uses.front().edge;
  const Edge before = data.edges[edge];
  std::pmr::vector<std::pair<Edge, Index>> edges(data.scratch.get());  // by their ends
  if (std::ranges::none_of(uses,
                           [&](const EdgeUse& use) { return ends_of(data, use) == before; })) {
    const Edge ends = ends_of(data, uses.front());
    point_edge(data, edge, ends);
    edges.emplace_back(ends, edge);
  } else {
    edges.emplace_back(before, edge);
  }
  for (const EdgeUse& use : uses) {
    const Edge ends = ends_of(data, use);
    auto known = std::ranges::find(edges, ends, &std::pair<Edge, Index>::first);
    if (known == edges.end()) {
      added.emplace_back(add_edge(data, ends), numbers_of(data, edge));
      known = edges.emplace(edges.end(), ends, added.back().first);
    }
    const Index now = known->second;
    if (now != edge) {
      auto of_tet = data.tet_edges[use.tet];
      of_tet[use.place] = now;
      data.set_tet(use.tet, data.tets[use.tet], of_tet);
      data.set_edge_tets(now, data.edge_tets[now] + 1);
      data.set_edge_tets(edge, data.edge_tets[edge] - 1);
    }
  }
}

// The owner of an edge may have left it.
void keep_owned(SolverData& data, Index edge) {
  const Index owner = data.edge_owners[edge];
  if (owner != kInvalidIndex && std::ranges::count(data.tet_edges[owner], edge) == 0) {
    data.hand_over(edge);
  }
}

}  // namespace

void move_corners(SolverData& data, const TopologyEdit& edit, EditResult& result) {
  const std::pmr::vector<EdgeUse> uses = find_uses(data, edit);
  for (const CornerMove& move : edit.corner_moves) {
    move_corner(data, move, result);
  }
  AddedEdges added(data.scratch.get());
  for (auto first = uses.begin(); first != uses.end();) {
    const auto last = std::find_if(first, uses.end(),
                                   [&](const EdgeUse& use) { return use.edge != first->edge; });
    part_edge(data, {first, last}, added);
    first = last;
  }
  for (auto use = uses.begin(); use != uses.end(); ++use) {
    if (use == uses.begin() || use->edge != (use - 1)->edge) {
      keep_owned(data, use->edge);
    }
  }
  for (const auto& [edge, numbers] : added) {
    add_edge_constraints(data, edge, numbers);
  }
}

void move_links(SolverData& data, const TopologyEdit& edit) {
  for (const LinkMove& move : edit.link_moves) {
    const Link& link = data.links[move.link];
    const Edge ends{link.first == move.from ? move.to : link.first,
                    link.second == move.from ? move.to : link.second};
    data.set_link(move.link, ends[0], ends[1]);
    data.remove_link_at(move.from, move.link);
    data.add_link_at(move.to, move.link);
    const Index distance = data.distance_ids.of_link(move.link);
    data.distances.set_places(distance, data.places_of(ends));
    data.log_constraint(PhaseKind::distance, distance);
  }
}

}  // namespace pbdsurg
