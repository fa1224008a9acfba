// SPDX-License-Identifier: Apache-2.0
#include "solver/add_bodies.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/coloring/color.h"
#include "pbdsurg/mesh/topology.h"

#include "solver/constraint_numbers.h"
#include "solver/growth.h"
#include "solver/nested_domains.h"

namespace pbdsurg {
namespace {

// The ids that the first of a scene's vertices, tetrahedra and edges get.
struct FirstIds {
  Index vertex, tet, edge;
};

void add_vertices(SolverData& data, const Scene& scene, const FirstIds& first) {
  const std::vector<Index> places = order_vertices(scene.positions());
  const std::size_t count = data.particles.size() + places.size();
  for (Index i = 0; i < data.copy_count(); ++i) {
    CopyState& state = data.copy(i);
    state.particles.resize(count);
    state.velocities.resize(count);
    state.falling.resize(data.options.method == SolverMethod::vertex_block ? count : 0, 1.0F);
    for (std::size_t v = 0; v < places.size(); ++v) {
      const Eigen::Vector3f x = scene.positions()[v].cast<float>();
      const bool is_fixed = scene.is_fixed(static_cast<Index>(v));
      state.particles[first.vertex + places[v]] = {x.x(), x.y(), x.z(), is_fixed ? 0.0F : 1.0F};
    }
  }
  data.previous.resize(count);
  for (const Index place : places) {
    data.log_moved(static_cast<Index>(data.place_of_vertex.size()));
    data.place_of_vertex.push_back(first.vertex + place);
  }
  data.vertex_masses.resize(count, 0);
  data.vertex_tets.resize(static_cast<Index>(count));
  data.vertex_links.resize(static_cast<Index>(count));
}

void add_to_bodies(SolverData& data, const Scene& scene, const FirstIds& first) {
  for (const Body& body : scene.bodies()) {
    const auto id = static_cast<Index>(data.bodies.size());
    data.bodies.push_back(body);
    data.bodies.back().first_vertex += first.vertex;
    data.bodies.back().first_tet += first.tet;
    data.tissue_counts.push_back(0);
    data.later_vertex_bodies.insert(data.later_vertex_bodies.end(), body.vertex_count, id);
  }
  data.has_damping = has_damping(data.bodies);
}

Tet moved(Tet tet, Index first) {
  for (Index& v : tet) {
    v += first;
  }
  return tet;
}

// Undo drops all that is new with its lists, so nothing of it is kept in mind.
void add_tets(SolverData& data, const Scene& scene, std::span<const Edge> edges,
              const FirstIds& first) {
  for (const Edge& edge : edges) {
    add_edge(data, {first.vertex + edge[0], first.vertex + edge[1]});
  }
  const auto tet_edges = find_tet_edges(scene.tets(), edges);
  const std::vector<double> masses = tet_masses_of(scene);
  const auto first_body = static_cast<Index>(data.bodies.size() - scene.bodies().size());
  for (std::size_t b = 0; b < scene.bodies().size(); ++b) {
    const Body& body = scene.bodies()[b];
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      const Tet vertices = moved(scene.tets()[t], first.vertex);
      const Index id = add_tet(data, vertices, first_body + static_cast<Index>(b), masses[t]);
      for (std::size_t e = 0; e < 6; ++e) {
        data.tet_edges[id][e] = first.edge + tet_edges[t][e];
        ++data.edge_tets[data.tet_edges[id][e]];
      }
      for (const Index v : vertices) {
        data.vertex_tets.insert(v, id);
      }
    }
  }
}

// A constraint that is to come.
template <class Constraint>
struct NewConstraint {
  static constexpr std::size_t kArity = Constraint::kVertexCount;
  Index id;
  std::array<Index, kArity> vertices;
  ConstraintRecord<Constraint> record;
};

// Adds constraints of vertices that have none yet.
template <class Constraint>
void add_apart(SolverData& data, PhaseKind kind, ConstraintSlots<Constraint>& slots,
               const FirstIds& first, std::vector<NewConstraint<Constraint>> added) {
  using Places = std::array<Index, NewConstraint<Constraint>::kArity>;
  std::ranges::stable_sort(added, {}, [](const NewConstraint<Constraint>& each) {
    return std::ranges::min(each.record.places);  // as those of a scene lie
  });
  std::vector<Places> places;
  for (const NewConstraint<Constraint>& each : added) {
    places.push_back(each.record.places);
    for (Index& place : places.back()) {
      place -= first.vertex;  // new places follow the others, as new vertices do
    }
  }
  const Coloring coloring = color_constraints(
      {std::span<const Places>(places), static_cast<Index>(data.particles.size()) - first.vertex},
      data.options.coloring);
  const std::vector<Index> groups = groups_to_join(data, kind, coloring.color_count);
  const auto is_over = [&](std::size_t i) { return coloring.color_of[i] == kOverflowColor; };
  for (std::size_t i = 0; i < added.size(); ++i) {
    if (!is_over(i)) {
      slots.add(added[i].id, groups[coloring.color_of[i]], added[i].record);
      data.log_constraint(kind, added[i].id);
    }
  }
  for (std::size_t i = 0; i < added.size(); ++i) {
    if (is_over(i)) {
      const Index group = find_free_group(data, kind, added[i].vertices);
      slots.add(added[i].id, group, added[i].record);
      data.log_constraint(kind, added[i].id);
    }
  }
}

void add_constraints(SolverData& data, const ConstraintNumbers& numbers, const FirstIds& first) {
  std::vector<NewConstraint<VolumeConstraint>> volumes;
  std::vector<NewConstraint<NeoHookeanConstraint>> neo_hookeans;
  for (std::size_t i = 0; i < numbers.tets.size(); ++i) {
    const Index id = first.tet + static_cast<Index>(i);
    const Tet& vertices = data.tets[id];
    const Tet places = data.places_of(vertices);
    if (numbers.tets[i].volume) {
      volumes.push_back({id, vertices, {places, *numbers.tets[i].volume}});
    }
    if (numbers.tets[i].neo_hookean) {
      neo_hookeans.push_back({id, vertices, {places, *numbers.tets[i].neo_hookean}});
    }
  }
  std::vector<NewConstraint<DistanceConstraint>> distances;
  std::vector<NewConstraint<StrainLimitConstraint>> limits;
  for (std::size_t i = 0; i < numbers.edges.size(); ++i) {
    const Index id = first.edge + static_cast<Index>(i);
    const Edge& vertices = data.edges[id];
    const Edge places = data.places_of(vertices);
    if (numbers.edges[i].distance) {
      distances.push_back(
          {data.distance_ids.of_edge(id), vertices, {places, *numbers.edges[i].distance}});
    }
    if (numbers.edges[i].limit) {
      limits.push_back({id, vertices, {places, *numbers.edges[i].limit}});
    }
  }
  add_apart(data, PhaseKind::volume, data.volumes, first, std::move(volumes));
  add_apart(data, PhaseKind::distance, data.distances, first, std::move(distances));
  add_apart(data, PhaseKind::neo_hookean, data.neo_hookeans, first, std::move(neo_hookeans));
  add_apart(data, PhaseKind::strain_limit, data.strain_limits, first, std::move(limits));
}

}  // namespace

void add_bodies(SolverData& data, const Scene& scene) {
  if (scene.bodies().empty()) {
    return;
  }
  const FirstIds first{static_cast<Index>(data.particles.size()),
                       static_cast<Index>(data.tets.size()), static_cast<Index>(data.edges.size())};
  const std::vector<Edge> edges = find_edges(scene.tets());
  add_vertices(data, scene, first);
  add_to_bodies(data, scene, first);
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    data.set_mass(first.vertex + v, scene.masses()[v]);
  }
  add_tets(data, scene, edges, first);
  add_constraints(data, numbers_at_rest(scene, edges, data.options.mode), first);
}

void undo_bodies(SolverData& data) {
  data.bodies.erase(data.bodies.begin() + static_cast<std::ptrdiff_t>(data.journal.body_count),
                    data.bodies.end());
  data.tissue_counts.resize(data.journal.body_count);
  data.has_damping = has_damping(data.bodies);
}

}  // namespace pbdsurg
