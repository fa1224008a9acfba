// SPDX-License-Identifier: Apache-2.0
#include "solver/solver_input.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/core/error.h"

#include "solver/backend.h"
#include "solver/build_constraints.h"
#include "solver/growth.h"
#include "solver/nested_domains.h"
#include "solver/solver_data.h"
#include "solver/vertex_method.h"

namespace pbdsurg {
namespace {

IndexLists find_vertex_links(Index vertex_count, std::span<const Link> links) {
  std::vector<Edge> ends;
  for (const Link& link : links) {
    ends.push_back({link.first, link.second});
  }
  return find_vertex_constraints({std::span<const Edge>(ends), vertex_count});
}

void take_topology(SolverInput& input, SolverData& data) {
  const auto vertex_count = static_cast<Index>(input.positions.size());
  data.tets = std::move(input.tets);
  data.links = std::move(input.links);
  data.edges = std::move(input.edges);
  data.vertex_links = VertexLists(find_vertex_links(vertex_count, data.links));
  data.vertex_tets = VertexLists(find_vertex_tets(vertex_count, data.tets));
  data.distance_ids =
      DistanceIds(static_cast<Index>(data.edges.size()), static_cast<Index>(data.links.size()));
  data.tet_edges = find_tet_edges(data.tets, data.edges);
  data.edge_tets.assign(data.edges.size(), 0);
  data.tet_alive.assign(data.tets.size(), true);
  for (const auto& edges_of_tet : data.tet_edges) {
    for (const Index edge : edges_of_tet) {
      ++data.edge_tets[edge];
    }
  }
}

void place_vertices(const SolverInput& input, SolverData& data) {
  const std::size_t vertex_count = input.positions.size();
  data.place_of_vertex = order_vertices(input.positions);
  data.particles.resize(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const Eigen::Vector3f x = input.positions[v].cast<float>();
    const bool moves = input.vertex_masses[v] > 0 && !input.is_fixed[v];
    data.particle(static_cast<Index>(v)) = {
        x.x(), x.y(), x.z(), moves ? static_cast<float>(1 / input.vertex_masses[v]) : 0.0F};
  }
  data.previous = data.particles;
  data.velocities.assign(vertex_count, {});
  if (input.options.method == SolverMethod::vertex_block) {
    data.falling.assign(vertex_count, 1.0F);
  }
}

std::string plan_name(const SolverOptions& options) {
  const bool moves_vertices = options.method == SolverMethod::vertex_block;
  const ColoringOptions coloring = moves_vertices ? vertex_coloring(options) : options.coloring;
  std::string name = name_of(coloring.algorithm);
  if (coloring.algorithm == ColoringAlgorithm::greedy && coloring.order != GreedyOrder::natural) {
    name += std::string(" by ") + name_of(coloring.order);
  }
  if (coloring.algorithm == ColoringAlgorithm::random_disc &&
      coloring.disc.palette == Palette::conflicts) {
    name += " by conflicts";
  }
  name += coloring.repair ? "+repair" : "";
  name += coloring.max_colors > 0 ? "+limit " + std::to_string(coloring.max_colors) : "";
  name += coloring.balance ? "+balance" : "";
  if (moves_vertices) {
    return name + ", vertices";
  }
  switch (options.composition) {
    case PlanComposition::automatic:
      break;
    case PlanComposition::separate:
      return name + ", distances then volumes";
    case PlanComposition::joint:
      return name + ", joint";
    case PlanComposition::nested:
      return name + ", nested";
  }
  return name;
}

}  // namespace

SolverInput input_of(const Scene& scene, const SolverOptions& options) {
  SolverInput input;
  input.options = options;
  input.gravity = scene.gravity();
  input.bodies.assign(scene.bodies().begin(), scene.bodies().end());
  input.positions.assign(scene.positions().begin(), scene.positions().end());
  input.vertex_masses.assign(scene.masses().begin(), scene.masses().end());
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    input.is_fixed.push_back(scene.is_fixed(v));
  }
  input.tets.assign(scene.tets().begin(), scene.tets().end());
  input.tet_masses = tet_masses_of(scene);
  input.edges = find_edges(scene.tets());
  input.links.assign(scene.links().begin(), scene.links().end());
  input.numbers = numbers_at_rest(scene, input.edges, options.mode);
  if (options.method == SolverMethod::vertex_block) {
    input.vertex_tets = vertex_tets_at_rest(scene);
  }
  return input;
}

std::unique_ptr<SolverData> build_solver_data(SolverInput input) {
  auto made = std::make_unique<SolverData>();
  SolverData& data = *made;
  data.options = input.options;
  data.gravity = input.gravity;
  data.bodies = std::move(input.bodies);
  place_vertices(input, data);
  data.vertex_masses = std::move(input.vertex_masses);
  data.tissue_counts.assign(data.bodies.size(), 0);
  for (std::size_t v = 0; v < data.vertex_masses.size(); ++v) {
    data.tissue_counts[data.body_of_vertex(static_cast<Index>(v))] += data.vertex_masses[v] > 0;
  }
  data.tet_masses = std::move(input.tet_masses);
  take_topology(input, data);
  build_constraints(input.numbers, data);
  data.has_damping = has_damping(data.bodies);
  data.vertex_method = make_vertex_method(data, std::move(input.vertex_tets));
  data.others.assign(static_cast<std::size_t>(data.options.copies) - 1, data);
  reserve_spare_room(data);
  data.changes.state.assign(static_cast<std::size_t>(data.options.copies), true);
  data.plan.name = plan_name(data.options);
  data.rebuild_plan();
  return made;
}

std::unique_ptr<Backend> make_host_backend(const SolverOptions& options) {
  if (options.backend == BackendKind::serial) {
    return make_serial_backend();
  }
  std::unique_ptr<Backend> backend = make_threaded_backend(options);
  if (backend == nullptr && options.backend == BackendKind::threaded) {
    throw BackendUnavailable(
        "the threaded backend has no kernels for this processor; it has them for x86-64 with "
        "SSSE3, AVX2 or AVX-512");
  }
  return backend == nullptr ? make_serial_backend() : std::move(backend);
}

}  // namespace pbdsurg
