// SPDX-License-Identifier: Apache-2.0
#include "edit/removal.h"

#include <algorithm>
#include <vector>

#include "solver/vertex_method.h"

namespace pbdsurg {

void prefetch_removals(const SolverData& data, std::span<const Index> tets) {
  for (const Index t : tets) {
    __builtin_prefetch(&data.tet_edges[t]);
    __builtin_prefetch(&data.tet_masses[t]);
    data.volumes.prefetch_location(t);
    for (const Index v : data.tets[t]) {
      __builtin_prefetch(data.vertex_tets[v].data());
      __builtin_prefetch(&data.vertex_masses[v]);
      __builtin_prefetch(&data.place_of_vertex[v]);
    }
  }
  for (const Index t : tets) {
    data.volumes.prefetch_removal(t);
    for (const Index edge : data.tet_edges[t]) {
      __builtin_prefetch(&data.edge_tets[edge]);
      data.distances.prefetch_location(data.distance_ids.of_edge(edge));
    }
    for (const Index v : data.tets[t]) {
      __builtin_prefetch(&data.particle(v));
    }
  }
  for (const Index t : tets) {
    for (const Index edge : data.tet_edges[t]) {
      if (data.edge_tets[edge] == 1) {  // others may go, too, as the last of several
        data.distances.prefetch_removal(data.distance_ids.of_edge(edge));
      }
    }
  }
}

void remove_link(SolverData& data, Index link, EditResult& result) {
  const Index distance = data.distance_ids.of_link(link);
  data.distances.remove(distance);
  data.log_constraint(PhaseKind::distance, distance);
  remove_vertex_spring(data, distance);
  data.remove_link_at(data.links[link].first, link);
  data.remove_link_at(data.links[link].second, link);
  result.links.push_back(link);
}

void remove_tet(SolverData& data, Index tet, EditResult& result) {
  data.tet_alive[tet] = false;
  data.journal.tets.push_back(tet);
  data.log_tet(tet);
  remove_vertex_tet(data, tet);
  result.tets.push_back(tet);
  for (const Index edge : data.tet_edges[tet]) {
    data.set_edge_tets(edge, data.edge_tets[edge] - 1);
    if (data.edge_tets[edge] == 0) {
      data.remove_edge(edge);
      result.edges.push_back(edge);
    }
  }
  if (data.volumes.is_alive(tet)) {
    data.remove_volume(tet);
  }
  if (data.neo_hookeans.is_alive(tet)) {
    data.neo_hookeans.remove(tet);
    data.log_constraint(PhaseKind::neo_hookean, tet);
  }
  for (const Index v : data.tets[tet]) {
    take_from_vertex(data, v, tet, result);
  }
}

void remove_body(SolverData& data, Index body, EditResult& result) {
  for_each_vertex_of(data, body, [&](Index v) {
    if (data.vertex_masses[v] > 0 && data.vertex_tets[v].empty()) {  // a particle
      data.set_mass(v, 0);
      result.vertices.push_back(v);
    }
  });
  for_each_tet_of(data, body, [&](Index t) {
    if (data.tet_alive[t]) {
      remove_tet(data, t, result);
    }
  });
}

void take_from_vertex(SolverData& data, Index vertex, Index tet, EditResult& result) {
  data.remove_tet_at(vertex, tet);
  if (data.vertex_tets[vertex].empty()) {
    result.vertices.push_back(vertex);
  }
}

void sum_masses(SolverData& data) {
  std::vector<Index>& vertices = data.edit_buffer;
  vertices.clear();
  for (const EditJournal::Entry& entry : data.journal.tet_entries) {
    vertices.push_back(entry.vertex);
  }
  std::ranges::sort(vertices);
  const auto end = std::unique(vertices.begin(), vertices.end());
  for (auto v = vertices.begin(); v != end; ++v) {
    double mass = 0;
    for (const Index tet : data.vertex_tets[*v]) {
      mass += data.tet_masses[tet] / 4;
    }
    data.set_mass(*v, mass);
  }
}

void release_vertices(SolverData& data, EditResult& result) {
  if (result.vertices.empty()) {
    return;
  }
  for (const Index v : result.vertices) {
    while (!data.vertex_links[v].empty()) {
      remove_link(data, data.vertex_links[v].front(), result);
    }
  }
  data.release_dead_vertices();
}

}  // namespace pbdsurg
