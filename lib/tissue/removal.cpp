// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/removal.h"

#include <algorithm>
#include <vector>

#include "lib/tissue/hinges.h"

namespace pbdsurg {

void prefetch_removals(const TissueData& data, std::span<const Index> tets) {
  for (const Index t : tets) {
    __builtin_prefetch(&data.tet_edges[t]);
    __builtin_prefetch(&data.tet_masses[t]);
    for (const Index v : data.tets[t]) {
      __builtin_prefetch(data.vertex_tets[v].data());
      __builtin_prefetch(&data.masses[v]);
    }
  }
  for (const Index t : tets) {
    for (const Index edge : data.tet_edges[t]) {
      __builtin_prefetch(&data.edge_tets[edge]);
    }
  }
}

void remove_link(TissueData& data, Index link) {
  data.link_alive.set(link, 0);
  data.vertex_links.erase(data.links[link].first, link);
  data.vertex_links.erase(data.links[link].second, link);
  data.change.removed_links.push_back(link);
}

void remove_tet(TissueData& data, Index tet) {
  remove_hinges(data, data.tets[tet]);
  take_out_tet(data, tet);
}

void take_out_tet(TissueData& data, Index tet) {
  data.tet_alive.set(tet, 0);
  data.change.removed_tets.push_back(tet);
  for (const Index edge : data.tet_edges[tet]) {
    data.edge_tets.set(edge, data.edge_tets[edge] - 1);
    if (data.edge_tets[edge] == 0) {
      data.change.removed_edges.push_back(edge);
    }
  }
  data.change.removed_edge_ends.push_back(static_cast<Index>(data.change.removed_edges.size()));
  for (const Index v : data.tets[tet]) {
    take_from_vertex(data, v, tet);
  }
}

void remove_body(TissueData& data, Index body) {
  for_each_vertex_of(data, body, [&](Index v) {
    if (data.masses[v] > 0 && !data.is_corner(v)) {  // a particle
      data.set_mass(v, 0);
      data.change.emptied_vertices.push_back(v);
    }
  });
  for_each_tet_of(data, body, [&](Index t) {
    if (data.tet_alive[t] != 0) {
      remove_tet(data, t);
    }
  });
  const Body& own = data.bodies[body];
  for (Index t = own.first_triangle; t < own.first_triangle + own.triangle_count; ++t) {
    if (data.triangle_alive[t] != 0) {
      remove_triangle(data, t);
    }
  }
}

void remove_triangle(TissueData& data, Index triangle) {
  remove_hinges(data, data.triangles[triangle]);
  data.triangle_alive.set(triangle, 0);
  data.change.removed_triangles.push_back(triangle);
  for (const Index v : data.triangles[triangle]) {
    take_triangle_from_vertex(data, v, triangle);
  }
}

void take_triangle_from_vertex(TissueData& data, Index vertex, Index triangle) {
  data.vertex_triangles.erase(vertex, triangle);
  data.buffer.push_back(vertex);
  if (data.triangles_at(vertex).empty()) {
    data.change.emptied_vertices.push_back(vertex);
  }
}

void take_from_vertex(TissueData& data, Index vertex, Index tet) {
  data.vertex_tets.erase(vertex, tet);
  data.buffer.push_back(vertex);
  if (data.vertex_tets[vertex].empty()) {
    data.change.emptied_vertices.push_back(vertex);
  }
}

void sum_masses(TissueData& data) {
  std::vector<Index>& vertices = data.buffer;
  std::ranges::sort(vertices);
  const auto end = std::unique(vertices.begin(), vertices.end());
  for (auto v = vertices.begin(); v != end; ++v) {
    double mass = 0;
    for (const Index tet : data.vertex_tets[*v]) {
      mass += data.tet_masses[tet] / 4;
    }
    for (const Index triangle : data.triangles_at(*v)) {
      mass += data.triangle_masses[triangle] / 3;
    }
    data.set_mass(*v, mass);
  }
}

void remove_links_of_emptied(TissueData& data) {
  for (const Index v : data.change.emptied_vertices) {
    while (!data.vertex_links[v].empty()) {
      remove_link(data, data.vertex_links[v].front());
    }
  }
}

}  // namespace pbdsurg
