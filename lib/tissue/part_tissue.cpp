// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/part_tissue.h"

#include <algorithm>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/removal.h"

namespace pbdsurg {
namespace {

// A tetrahedron that had an edge before corners moved, and the edge's place in kTetEdges.
struct EdgeUse {
  Index edge, tet, place;
};

// Edges at corners that move, ascending.
void find_corner_edges(TissueData& data, const TopologyEdit& edit) {
  std::vector<Index>& edges = data.change.corner_edges;
  for (const CornerMove& move : edit.corner_moves) {
    for (const Index edge : data.tet_edges[move.tet]) {
      if (data.edges[edge][0] == move.from || data.edges[edge][1] == move.from) {
        edges.push_back(edge);
      }
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

// Every tetrahedron around these edges, edge by edge, ascending.
std::pmr::vector<EdgeUse> find_uses(const TissueData& data) {
  std::pmr::vector<EdgeUse> uses(data.scratch.get());
  for (const Index edge : data.change.corner_edges) {
    for (const Index tet : data.vertex_tets[data.edges[edge][0]]) {
      const TetEdges& of_tet = data.tet_edges[tet];
      const auto place = std::ranges::find(of_tet, edge) - of_tet.begin();
      if (place < 6) {
        uses.push_back({edge, tet, static_cast<Index>(place)});
      }
    }
  }
  return uses;
}

void move_corner(TissueData& data, const CornerMove& move) {
  Tet vertices = data.tets[move.tet];
  std::ranges::replace(vertices, move.from, move.to);
  data.set_tet(move.tet, vertices, data.tet_edges[move.tet]);
  data.vertex_tets.insert(move.to, move.tet);
  data.buffer.push_back(move.to);
  take_from_vertex(data, move.from, move.tet);
}

Edge ends_of(const TissueData& data, const EdgeUse& use) {
  const Index a = data.tets[use.tet][kTetEdges[use.place][0]];
  const Index b = data.tets[use.tet][kTetEdges[use.place][1]];
  return {std::min(a, b), std::max(a, b)};
}

// Gives those that have an edge together no longer edges of their own.
// @param uses  of one edge
void part_edge(TissueData& data, std::span<const EdgeUse> uses) {
  const Index edge = uses.front().edge;
  const Edge before = data.edges[edge];
  std::pmr::vector<std::pair<Edge, Index>> edges(data.scratch.get());  // by their ends
  if (std::ranges::none_of(uses,
                           [&](const EdgeUse& use) { return ends_of(data, use) == before; })) {
    const Edge ends = ends_of(data, uses.front());
    data.edges.set(edge, ends);
    data.change.moved_edges.push_back(edge);
    edges.emplace_back(ends, edge);
  } else {
    edges.emplace_back(before, edge);
  }
  for (const EdgeUse& use : uses) {
    const Edge ends = ends_of(data, use);
    auto known = std::ranges::find(edges, ends, &std::pair<Edge, Index>::first);
    if (known == edges.end()) {
      data.change.parted_edges.push_back({data.add_edge(ends), edge});
      known = edges.emplace(edges.end(), ends, data.change.parted_edges.back().edge);
    }
    const Index now = known->second;
    if (now != edge) {
      TetEdges of_tet = data.tet_edges[use.tet];
      of_tet[use.place] = now;
      data.set_tet(use.tet, data.tets[use.tet], of_tet);
      data.edge_tets.set(now, data.edge_tets[now] + 1);
      data.edge_tets.set(edge, data.edge_tets[edge] - 1);
    }
  }
}

}  // namespace

void move_corners(TissueData& data, const TopologyEdit& edit) {
  find_corner_edges(data, edit);
  const std::pmr::vector<EdgeUse> uses = find_uses(data);
  for (const CornerMove& move : edit.corner_moves) {
    move_corner(data, move);
  }
  for (auto first = uses.begin(); first != uses.end();) {
    const auto last = std::find_if(first, uses.end(),
                                   [&](const EdgeUse& use) { return use.edge != first->edge; });
    part_edge(data, {first, last});
    first = last;
  }
}

void move_triangles(TissueData& data, const TopologyEdit& edit) {
  for (const TriangleMove& move : edit.triangle_moves) {
    Triangle vertices = data.triangles[move.triangle];
    std::ranges::replace(vertices, move.from, move.to);
    data.triangles.set(move.triangle, vertices);
    data.vertex_triangles.insert(move.to, move.triangle);
    data.buffer.push_back(move.to);
    take_triangle_from_vertex(data, move.from, move.triangle);
  }
}

void move_links(TissueData& data, const TopologyEdit& edit) {
  for (const LinkMove& move : edit.link_moves) {
    Link link = data.links[move.link];
    (link.first == move.from ? link.first : link.second) = move.to;
    data.links.set(move.link, link);
    data.vertex_links.erase(move.from, move.link);
    data.vertex_links.insert(move.to, move.link);
  }
}

}  // namespace pbdsurg
