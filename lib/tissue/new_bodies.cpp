// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/new_bodies.h"

#include <algorithm>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// The ids that the first of a scene's vertices, tetrahedra, triangles and edges get.
struct FirstIds {
  Index vertex, tet, triangle, edge;
};

void add_vertices(TissueData& data, const Scene& scene, const FirstIds& first) {
  for (const Body& body : scene.bodies()) {
    const Index id = data.bodies.size();
    Body added = body;
    added.first_vertex += first.vertex;
    added.first_tet += first.tet;
    added.first_triangle += first.triangle;
    data.bodies.push_back(added);
    data.tissue_counts.push_back(0);
    for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
      data.rest_positions.push_back(scene.positions()[v]);
      data.fixed.push_back(scene.is_fixed(v) ? 1 : 0);
      data.masses.push_back(0);
      data.later_vertex_bodies.push_back(id);
    }
  }
  data.resize_vertex_lists();
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    data.set_mass(first.vertex + v, scene.masses()[v]);
  }
}

void add_tets(TissueData& data, const Scene& scene, const FirstIds& first) {
  const std::vector<Edge> edges = find_edges(scene.tets());
  for (const Edge& edge : edges) {
    data.add_edge({first.vertex + edge[0], first.vertex + edge[1]});
  }
  const auto tet_edges = find_tet_edges(scene.tets(), edges);
  const Index first_body = data.bodies.size() - static_cast<Index>(scene.bodies().size());
  for (std::size_t b = 0; b < scene.bodies().size(); ++b) {
    const Body& body = scene.bodies()[b];
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      Tet vertices = scene.tets()[t];
      TetEdges edges_of_tet = tet_edges[t];
      for (Index& v : vertices) {
        v += first.vertex;
      }
      for (Index& edge : edges_of_tet) {
        edge += first.edge;
        data.edge_tets.set(edge, data.edge_tets[edge] + 1);
      }
      const double mass = body.material.density * tet_volume(scene.positions(), scene.tets()[t]);
      const Index id = data.add_tet(vertices, first_body + static_cast<Index>(b), mass,
                                    scene.stiffnesses()[t], scene.fibres()[t]);
      data.set_tet(id, vertices, edges_of_tet);
      for (const Index v : vertices) {
        data.vertex_tets.insert(v, id);
      }
    }
  }
}

void add_triangles(TissueData& data, const Scene& scene, const FirstIds& first) {
  for (const Body& body : scene.bodies()) {
    for (Index t = body.first_triangle; t < body.first_triangle + body.triangle_count; ++t) {
      Triangle vertices = scene.triangles()[t];
      std::ranges::for_each(vertices, [&](Index& v) { v += first.vertex; });
      data.add_triangle(vertices, triangle_mass(body, scene.positions(), scene.triangles()[t]),
                        scene.triangle_stiffnesses()[t]);
    }
  }
}

}  // namespace

void add_bodies(TissueData& data, const Scene& scene) {
  if (scene.bodies().empty()) {
    return;
  }
  const FirstIds first{data.vertex_count(), data.tets.size(), data.triangles.size(),
                       data.edges.size()};
  add_vertices(data, scene, first);
  add_tets(data, scene, first);
  add_triangles(data, scene, first);
}

}  // namespace pbdsurg
