// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/tissue_data.h"

#include <array>
#include <atomic>
#include <numeric>
#include <utility>

#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {
namespace {

std::array<Index, 2> vertices_of(const Link& link) {
  return {link.first, link.second};
}
const Triangle& vertices_of(const Triangle& triangle) {
  return triangle;
}
std::array<Index, 4> vertices_of(const Hinge& hinge) {
  return hinge.vertices;
}

template <class Element>
IndexLists find_at_vertices(Index vertex_count, std::span<const Element> elements) {
  IndexLists lists;
  lists.offsets.assign(static_cast<std::size_t>(vertex_count) + 1, 0);
  for (const Element& element : elements) {
    for (const Index v : vertices_of(element)) {
      ++lists.offsets[v + 1];
    }
  }
  std::partial_sum(lists.offsets.begin(), lists.offsets.end(), lists.offsets.begin());
  lists.entries.resize(static_cast<std::size_t>(lists.offsets.back()));
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const Index v : vertices_of(elements[i])) {
      lists.entries[next[v]++] = static_cast<Index>(i);
    }
  }
  return lists;
}

}  // namespace

void connect(TissueData& data) {
  std::vector<Edge> edges = find_edges(data.tets.values());
  std::vector<TetEdges> tet_edges = find_tet_edges(data.tets.values(), edges);
  std::vector<Index> edge_tets(edges.size(), 0);
  for (const TetEdges& of_tet : tet_edges) {
    for (const Index edge : of_tet) {
      ++edge_tets[edge];
    }
  }
  data.vertex_tets = VertexLists(find_vertex_tets(data.vertex_count(), data.tets.values()));
  if (data.triangles.size() > 0) {
    data.vertex_triangles =
        VertexLists(find_at_vertices(data.vertex_count(), data.triangles.values()));
  }
  data.vertex_links = VertexLists(find_at_vertices(data.vertex_count(), data.links.values()));
  if (data.hinges.size() > 0) {
    data.vertex_hinges = VertexLists(find_at_vertices(data.vertex_count(), data.hinges.values()));
  }
  data.edges = UndoArray(std::move(edges));
  data.tet_edges = UndoArray(std::move(tet_edges));
  data.edge_tets = UndoArray(std::move(edge_tets));
}

std::uint64_t next_tissue_identity() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

Index TissueData::body_of_vertex(Index vertex) const noexcept {
  const Index later = vertex - (vertex_count() - later_vertex_bodies.size());
  if (later >= 0) {
    return later_vertex_bodies[later];
  }
  const auto after = std::ranges::upper_bound(bodies.values(), vertex, {}, &Body::first_vertex);
  return static_cast<Index>(after - bodies.values().begin()) - 1;
}

Index TissueData::body_of_tet(Index tet) const noexcept {
  const Index later = tet - (tets.size() - later_tet_bodies.size());
  if (later >= 0) {
    return later_tet_bodies[later];
  }
  const auto after = std::ranges::upper_bound(bodies.values(), tet, {}, &Body::first_tet);
  return static_cast<Index>(after - bodies.values().begin()) - 1;
}

Index TissueData::body_of_triangle(Index triangle) const noexcept {
  const auto after = std::ranges::upper_bound(bodies.values(), triangle, {}, &Body::first_triangle);
  return static_cast<Index>(after - bodies.values().begin()) - 1;
}

Index TissueData::first_later_vertex(Index body) const noexcept {
  const Body& own = bodies[body];
  return std::max(own.first_vertex + own.vertex_count, vertex_count() - later_vertex_bodies.size());
}

Index TissueData::first_later_tet(Index body) const noexcept {
  const Body& own = bodies[body];
  return std::max(own.first_tet + own.tet_count, tets.size() - later_tet_bodies.size());
}

void TissueData::set_mass(Index vertex, double mass) {
  const Index body = body_of_vertex(vertex);
  const int growth = (mass > 0 ? 1 : 0) - (masses[vertex] > 0 ? 1 : 0);
  if (growth != 0) {
    tissue_counts.set(body, tissue_counts[body] + growth);
  }
  masses.set(vertex, mass);
  change.weighed_vertices.push_back(vertex);
}

void TissueData::set_tet(Index tet, const Tet& vertices, const TetEdges& edges_of_tet) {
  if (tet < change.first_new_tet) {
    change.reshaped_tets.push_back({tet, tets[tet], tet_edges[tet]});
  }
  tets.set(tet, vertices);
  tet_edges.set(tet, edges_of_tet);
}

void TissueData::add_vertex(const NewVertex& vertex) {
  const Eigen::Vector3d a = rest_positions[vertex.first], b = rest_positions[vertex.second];
  const Index body = body_of_vertex(vertex.first);  // while both arrays count alike
  rest_positions.push_back(
      vertex.first == vertex.second
          ? a
          : Eigen::Vector3d((1 - static_cast<double>(vertex.share)) * a + vertex.share * b));
  fixed.push_back(fixed[vertex.first] != 0 && fixed[vertex.second] != 0 ? 1 : 0);
  masses.push_back(0);
  later_vertex_bodies.push_back(body);
  resize_vertex_lists();
}

Index TissueData::add_edge(const Edge& ends) {
  edges.push_back(ends);
  edge_tets.push_back(0);
  return edges.size() - 1;
}

Index TissueData::add_tet(const Tet& vertices, Index body, double mass, float stiffness,
                          const Fibre& fibre) {
  tets.push_back(vertices);
  tet_edges.push_back({});
  tet_alive.push_back(1);
  tet_masses.push_back(mass);
  stiffnesses.push_back(stiffness);
  fibres.push_back(fibre);
  later_tet_bodies.push_back(body);
  return tets.size() - 1;
}

void TissueData::add_triangle(const Triangle& vertices, double mass, float stiffness) {
  const Index id = triangles.size();
  triangles.push_back(vertices);
  triangle_alive.push_back(1);
  triangle_masses.push_back(mass);
  triangle_stiffnesses.push_back(stiffness);
  resize_vertex_lists();  // the first of all
  for (const Index v : vertices) {
    vertex_triangles.insert(v, id);
  }
}

void TissueData::add_link(const Link& link) {
  const Index id = links.size();
  links.push_back(link);
  link_alive.push_back(1);
  vertex_links.insert(link.first, id);
  vertex_links.insert(link.second, id);
}

void TissueData::add_hinge(const Hinge& hinge) {
  const Index id = hinges.size();
  hinges.push_back(hinge);
  hinge_alive.push_back(1);
  resize_vertex_lists();  // the first of all
  for (const Index v : hinge.vertices) {
    vertex_hinges.insert(v, id);
  }
}

void TissueData::resize_vertex_lists() {
  const auto count = static_cast<std::size_t>(vertex_count());
  vertex_tets.resize(count);
  vertex_links.resize(count);
  if (triangles.size() > 0) {
    vertex_triangles.resize(count);
  }
  if (hinges.size() > 0) {
    vertex_hinges.resize(count);
  }
}

}  // namespace pbdsurg
