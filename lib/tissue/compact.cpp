// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/compact.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

// Gives what lives ids in the order of bodies, and within a body in that of the old ids.
// @param first  [body] the first id of each
template <class BodyOf>
std::vector<Index> renumber(Index count, std::vector<Index> first, BodyOf living_body_of) {
  std::vector<Index> ids(static_cast<std::size_t>(count), kInvalidIndex);
  for (Index i = 0; i < count; ++i) {
    const Index body = living_body_of(i);
    if (body != kInvalidIndex) {
      ids[i] = first[body]++;
    }
  }
  return ids;
}

std::size_t count_living(const std::vector<Index>& ids) {
  return ids.size() - static_cast<std::size_t>(std::ranges::count(ids, kInvalidIndex));
}

// Bodies that live, with the room of what lives in them.
void renumber_bodies(const TissueData& data, TissueData& made, Renumbering& ids) {
  const auto body_count = static_cast<std::size_t>(data.bodies.size());
  std::vector<Index> tet_counts(body_count, 0), triangle_counts(body_count, 0);
  for (Index t = 0; t < data.tets.size(); ++t) {
    if (data.tet_alive[t] != 0) {
      ++tet_counts[data.body_of_tet(t)];
    }
  }
  for (Index t = 0; t < data.triangles.size(); ++t) {
    if (data.triangle_alive[t] != 0) {
      ++triangle_counts[data.body_of_triangle(t)];
    }
  }
  std::vector<Index> first_vertex, first_tet, first_triangle;
  Index vertex = 0, tet = 0, triangle = 0;
  for (Index b = 0; b < data.bodies.size(); ++b) {
    first_vertex.push_back(vertex);
    first_tet.push_back(tet);
    first_triangle.push_back(triangle);
    const bool lives = data.tissue_counts[b] > 0;
    ids.bodies.push_back(lives ? made.bodies.size() : kInvalidIndex);
    if (lives) {
      made.bodies.push_back({data.bodies[b].name, data.bodies[b].material, vertex,
                             data.tissue_counts[b], tet, tet_counts[b], triangle,
                             triangle_counts[b], data.bodies[b].thickness});
      made.tissue_counts.push_back(data.tissue_counts[b]);
    }
    vertex += data.tissue_counts[b];
    tet += tet_counts[b];
    triangle += triangle_counts[b];
  }
  ids.vertices = renumber(data.vertex_count(), std::move(first_vertex), [&](Index v) {
    return data.masses[v] > 0 ? data.body_of_vertex(v) : kInvalidIndex;
  });
  ids.tets = renumber(data.tets.size(), std::move(first_tet), [&](Index t) {
    return data.tet_alive[t] != 0 ? data.body_of_tet(t) : kInvalidIndex;
  });
  ids.triangles = renumber(data.triangles.size(), std::move(first_triangle), [&](Index t) {
    return data.triangle_alive[t] != 0 ? data.body_of_triangle(t) : kInvalidIndex;
  });
}

template <class Value>
UndoArray<Value> moved_array(const std::vector<Index>& ids, std::size_t count,
                             const UndoArray<Value>& from) {
  return UndoArray(moved<Value>(ids, count, [&](Index i) { return from[i]; }));
}

// Corners of what lives, by their new ids.
template <class Corners>
UndoArray<Corners> moved_corners(const std::vector<Index>& ids, const Renumbering& all,
                                 const UndoArray<Corners>& from) {
  return UndoArray(moved<Corners>(ids, count_living(ids), [&](Index i) {
    Corners corners = from[i];
    std::ranges::transform(corners, corners.begin(), [&](Index v) { return all.vertices[v]; });
    return corners;
  }));
}

// Appends what lives, with other ends.
// @return  [old id] new id
template <class Element, class SetEnds>
std::vector<Index> keep_living(const UndoArray<Element>& from,
                               const UndoArray<std::uint8_t>& from_alive, UndoArray<Element>& to,
                               UndoArray<std::uint8_t>& to_alive, SetEnds set_ends) {
  std::vector<Index> ids;
  for (Index i = 0; i < from.size(); ++i) {
    if (from_alive[i] == 0) {
      ids.push_back(kInvalidIndex);
      continue;
    }
    ids.push_back(to.size());
    Element element = from[i];
    set_ends(element);
    to.push_back(element);
    to_alive.push_back(1);
  }
  return ids;
}

}  // namespace

std::unique_ptr<TissueData> copy_of_elements(const TissueData& data) {
  auto copy = std::make_unique<TissueData>();
  copy->gravity = data.gravity;
  copy->bodies = data.bodies;
  copy->tissue_counts = data.tissue_counts;
  copy->later_vertex_bodies = data.later_vertex_bodies;
  copy->later_tet_bodies = data.later_tet_bodies;
  copy->rest_positions = data.rest_positions;
  copy->fixed = data.fixed;
  copy->masses = data.masses;
  copy->tets = data.tets;
  copy->tet_alive = data.tet_alive;
  copy->tet_masses = data.tet_masses;
  copy->stiffnesses = data.stiffnesses;
  copy->fibres = data.fibres;
  copy->triangles = data.triangles;
  copy->triangle_alive = data.triangle_alive;
  copy->triangle_masses = data.triangle_masses;
  copy->triangle_stiffnesses = data.triangle_stiffnesses;
  copy->edges = data.edges;
  copy->edge_tets = data.edge_tets;
  copy->links = data.links;
  copy->link_alive = data.link_alive;
  copy->hinges = data.hinges;
  copy->hinge_alive = data.hinge_alive;
  copy->version = data.version;
  return copy;
}

std::unique_ptr<TissueData> copy_of(const TissueData& data) {
  std::unique_ptr<TissueData> copy = copy_of_elements(data);
  copy->vertex_tets = data.vertex_tets;
  copy->vertex_triangles = data.vertex_triangles;
  copy->vertex_links = data.vertex_links;
  copy->vertex_hinges = data.vertex_hinges;
  copy->tet_edges = data.tet_edges;
  copy->identity = next_tissue_identity();
  copy->last_version = data.last_version;
  return copy;
}

Scene scene_of(const TissueData& data) {
  const auto vector_of = [](const auto& array) {
    return std::vector(array.values().begin(), array.values().end());
  };
  Scene scene;
  scene.bodies_ = vector_of(data.bodies);
  scene.positions_ = vector_of(data.rest_positions);
  scene.masses_ = vector_of(data.masses);
  scene.fixed_.assign(data.fixed.values().begin(), data.fixed.values().end());
  scene.tets_ = vector_of(data.tets);
  scene.triangles_ = vector_of(data.triangles);
  scene.stiffnesses_ = vector_of(data.stiffnesses);
  scene.triangle_stiffnesses_ = vector_of(data.triangle_stiffnesses);
  scene.fibres_ = vector_of(data.fibres);
  scene.links_ = vector_of(data.links);
  scene.hinges_ = vector_of(data.hinges);
  scene.gravity_ = data.gravity;
  return scene;
}

std::unique_ptr<TissueData> compact(const TissueData& data, Renumbering& ids) {
  auto compacted = std::make_unique<TissueData>();
  TissueData& made = *compacted;
  made.gravity = data.gravity;
  renumber_bodies(data, made, ids);
  const std::size_t vertex_count = count_living(ids.vertices), tet_count = count_living(ids.tets);
  made.rest_positions = moved_array(ids.vertices, vertex_count, data.rest_positions);
  made.fixed = moved_array(ids.vertices, vertex_count, data.fixed);
  made.masses = moved_array(ids.vertices, vertex_count, data.masses);
  made.tets = moved_corners(ids.tets, ids, data.tets);
  made.tet_alive = UndoArray(std::vector<std::uint8_t>(tet_count, 1));
  made.tet_masses = moved_array(ids.tets, tet_count, data.tet_masses);
  made.stiffnesses = moved_array(ids.tets, tet_count, data.stiffnesses);
  made.fibres = moved_array(ids.tets, tet_count, data.fibres);
  made.triangles = moved_corners(ids.triangles, ids, data.triangles);
  const auto triangle_count = static_cast<std::size_t>(made.triangles.size());
  made.triangle_alive = UndoArray(std::vector<std::uint8_t>(triangle_count, 1));
  made.triangle_masses = moved_array(ids.triangles, triangle_count, data.triangle_masses);
  made.triangle_stiffnesses = moved_array(ids.triangles, triangle_count, data.triangle_stiffnesses);
  ids.links =
      keep_living(data.links, data.link_alive, made.links, made.link_alive, [&](Link& link) {
        link.first = ids.vertices[link.first];
        link.second = ids.vertices[link.second];
      });
  ids.hinges =
      keep_living(data.hinges, data.hinge_alive, made.hinges, made.hinge_alive, [&](Hinge& hinge) {
        std::ranges::transform(hinge.vertices, hinge.vertices.begin(),
                               [&](Index v) { return ids.vertices[v]; });
      });
  connect(made);
  for (Index e = 0; e < data.edges.size(); ++e) {
    const auto [a, b] = data.edges[e];
    ids.edges.push_back(data.edge_tets[e] > 0
                            ? find_edge(made.edges.values(), ids.vertices[a], ids.vertices[b])
                            : kInvalidIndex);
  }
  return compacted;
}

void replace(TissueData& data, TissueData&& compacted, std::uint64_t version) {
  compacted.identity = data.identity;
  compacted.followers = std::move(data.followers);
  compacted.version = compacted.last_version = version;
  std::swap(data, compacted);
}

}  // namespace pbdsurg
