// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/compaction.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

#include "edit/renumbering.h"
#include "solver/backend.h"
#include "solver/growth.h"
#include "solver/solver_data.h"
#include "solver/solver_input.h"

namespace pbdsurg {
namespace {

// What a new solver is made of.
void copy_topology(const SolverData& from, SolverData& to) {
  to.options = from.options;
  to.gravity = from.gravity;
  to.bodies = from.bodies;
  to.tissue_counts = from.tissue_counts;
  to.later_vertex_bodies = from.later_vertex_bodies;
  to.later_tet_bodies = from.later_tet_bodies;
  to.place_of_vertex = from.place_of_vertex;
  to.particles = from.particles;
  to.tets = from.tets;
  to.tet_alive = from.tet_alive;
  to.tet_masses = from.tet_masses;
  to.vertex_masses = from.vertex_masses;
  to.edges = from.edges;
  to.edge_tets = from.edge_tets;
  to.links = from.links;
  to.distance_ids = from.distance_ids;
  to.distances = from.distances;
  to.volumes = from.volumes;
  to.neo_hookeans = from.neo_hookeans;
  to.strain_limits = from.strain_limits;
  to.vertex_method.blocks = from.vertex_method.blocks;
  to.topology_version = from.topology_version;
}

// Gives what lives ids in the order of bodies, and within a body in that of the old ids.
// @param first  [body] the first id of each
template <class BodyOf>
std::vector<Index> renumber(std::size_t count, std::vector<Index> first, BodyOf living_body_of) {
  std::vector<Index> ids(count, kInvalidIndex);
  for (std::size_t i = 0; i < count; ++i) {
    const Index body = living_body_of(static_cast<Index>(i));
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
std::vector<Body> renumber_bodies(const SolverData& data, Renumbering& ids) {
  std::vector<Index> vertex_counts(data.bodies.size(), 0), tet_counts(data.bodies.size(), 0);
  const auto body_of_vertex = [&](Index v) {
    return data.vertex_masses[v] > 0 ? data.body_of_vertex(v) : kInvalidIndex;
  };
  const auto body_of_tet = [&](Index t) {
    return data.tet_alive[t] ? data.body_of_tet(t) : kInvalidIndex;
  };
  for (std::size_t t = 0; t < data.tets.size(); ++t) {
    if (data.tet_alive[t]) {
      ++tet_counts[data.body_of_tet(static_cast<Index>(t))];
    }
  }
  std::vector<Body> bodies;
  std::vector<Index> first_vertex, first_tet;
  Index vertex = 0, tet = 0;
  for (std::size_t b = 0; b < data.bodies.size(); ++b) {
    first_vertex.push_back(vertex);
    first_tet.push_back(tet);
    const bool lives = data.tissue_counts[b] > 0;
    ids.bodies.push_back(lives ? static_cast<Index>(bodies.size()) : kInvalidIndex);
    if (lives) {
      bodies.push_back({data.bodies[b].name, data.bodies[b].material, vertex, data.tissue_counts[b],
                        tet, tet_counts[b]});
    }
    vertex += data.tissue_counts[b];
    tet += tet_counts[b];
  }
  ids.vertices = renumber(data.vertex_masses.size(), std::move(first_vertex), body_of_vertex);
  ids.tets = renumber(data.tets.size(), std::move(first_tet), body_of_tet);
  return bodies;
}

// @param positions  [vertex_count] m
SolverInput renumber_tissue(const SolverData& data, std::span<const Eigen::Vector3f> positions,
                            Renumbering& ids) {
  SolverInput input;
  input.options = data.options;
  input.gravity = data.gravity;
  input.bodies = renumber_bodies(data, ids);
  const std::size_t vertex_count = count_living(ids.vertices);
  input.positions = moved<Eigen::Vector3d>(ids.vertices, vertex_count, [&](Index v) {
    return positions[v].allFinite() ? Eigen::Vector3d(positions[v].cast<double>())
                                    : Eigen::Vector3d(Eigen::Vector3d::Zero());
  });
  input.vertex_masses =
      moved<double>(ids.vertices, vertex_count, [&](Index v) { return data.vertex_masses[v]; });
  input.is_fixed =
      moved<bool>(ids.vertices, vertex_count, [&](Index v) { return data.particle(v).w == 0; });

  const std::size_t tet_count = count_living(ids.tets);
  input.tets = moved<Tet>(ids.tets, tet_count, [&](Index t) {
    Tet tet = data.tets[t];
    std::ranges::transform(tet, tet.begin(), [&](Index v) { return ids.vertices[v]; });
    return tet;
  });
  input.tet_masses =
      moved<double>(ids.tets, tet_count, [&](Index t) { return data.tet_masses[t]; });
  input.numbers.tets =
      moved<TetNumbers>(ids.tets, tet_count, [&](Index t) { return tet_numbers_of(data, t); });
  if (data.options.method == SolverMethod::vertex_block) {
    input.vertex_tets = moved<VertexTet>(ids.tets, tet_count,
                                         [&](Index t) { return data.vertex_method.blocks.tet(t); });
  }

  input.edges = find_edges(input.tets);
  for (std::size_t e = 0; e < data.edges.size(); ++e) {
    const auto [a, b] = data.edges[e];
    ids.edges.push_back(data.edge_tets[e] > 0
                            ? find_edge(input.edges, ids.vertices[a], ids.vertices[b])
                            : kInvalidIndex);
  }
  input.numbers.edges = moved<EdgeNumbers>(ids.edges, input.edges.size(),
                                           [&](Index e) { return numbers_of(data, e); });

  for (std::size_t l = 0; l < data.links.size(); ++l) {
    if (!data.is_link_alive(static_cast<Index>(l))) {
      ids.links.push_back(kInvalidIndex);
      continue;
    }
    ids.links.push_back(static_cast<Index>(input.links.size()));
    Link link = data.links[l];
    link.first = ids.vertices[link.first];
    link.second = ids.vertices[link.second];
    input.links.push_back(link);
  }
  return input;
}

StepReport renumbered(StepReport report, const Renumbering& ids) {
  if (report.first_non_finite != kInvalidIndex) {
    report.first_non_finite = ids.vertices[report.first_non_finite];
  }
  return report;
}

void move_state(const SolverData& from, SolverData& to, const Renumbering& ids) {
  for (Index i = 0; i < from.copy_count(); ++i) {
    const CopyState& before = from.copy(i);
    CopyState& now = to.copy(i);
    for (std::size_t v = 0; v < ids.vertices.size(); ++v) {
      if (ids.vertices[v] == kInvalidIndex) {
        continue;
      }
      const Index old_place = from.place_of_vertex[v];
      const Index place = to.place_of_vertex[ids.vertices[v]];
      const Particle& p = before.particles[old_place];
      now.particles[place] = {p.x, p.y, p.z, now.particles[place].w};
      now.velocities[place] = before.velocities[old_place];
      if (!now.falling.empty()) {
        now.falling[place] = before.falling[old_place];
      }
    }
    now.tools = before.tools;
    for (ToolState& tool : now.tools) {
      for (Attachment& held : tool.attachments) {
        held.vertex = ids.vertices[held.vertex];
      }
      tool.contacts.clear();  // of a substep, by places
    }
    now.attachment_colors = before.attachment_colors;
    now.watched_positions = before.watched_positions;
    now.last_report = renumbered(before.last_report, ids);
  }
  reserve_tools(to);
  to.step_in_flight = from.step_in_flight;
  to.report = renumbered(from.report, ids);
  to.last_topology_version = to.topology_version = ids.version;
  to.rebuild_plan();
}

}  // namespace

struct Compaction::Parts {
  static constexpr const char* kWho = "a compaction";

  std::shared_ptr<const char> origin;  // the solver's identity
  Backend::Maker make_backend;
  SolverData copy;
  std::vector<Eigen::Vector3f> positions;  // m, of the first copy
  std::unique_ptr<SolverData> built;
  Renumbering ids;
  bool is_used = false;
};

Compaction::Compaction(const Solver& solver) : parts_(std::make_unique<Parts>()) {
  parts_->positions = solver.positions();
  const SolverData& data = solver_data(solver);
  parts_->origin = data.identity;
  parts_->make_backend = data.backend->maker();
  copy_topology(data, parts_->copy);
}

Compaction::~Compaction() = default;
Compaction::Compaction(Compaction&&) noexcept = default;
Compaction& Compaction::operator=(Compaction&&) noexcept = default;

void Compaction::build() {
  Renumbering ids;
  std::unique_ptr<SolverData> built =
      build_solver_data(renumber_tissue(parts_->copy, parts_->positions, ids));
  built->backend = parts_->make_backend(*built);
  ids.version_before = parts_->copy.topology_version;
  parts_->ids = std::move(ids);
  parts_->built = std::move(built);
}

Renumbering Compaction::finish(Solver& solver) {
  SolverData& data = solver_data(solver);
  if (parts_->built == nullptr || parts_->is_used) {
    throw InvalidArgument("a compaction is finished once, after build()");
  }
  if (data.identity != parts_->origin || data.topology_version != parts_->ids.version_before) {
    throw InvalidArgument("the compaction is of topology version " +
                          std::to_string(parts_->ids.version_before) +
                          " of a solver; this is another, or was edited since and is at " +
                          std::to_string(data.topology_version));
  }
  data.finish_running_step();
  std::vector<Index> vertex_at(data.place_of_vertex.size());
  for (std::size_t v = 0; v < vertex_at.size(); ++v) {
    vertex_at[data.place_of_vertex[v]] = static_cast<Index>(v);
  }
  SolverData& built = *parts_->built;
  built.watched_places.clear();
  for (const Index place : data.watched_places) {
    const Index v = vertex_at[place];
    if (parts_->ids.vertices[v] == kInvalidIndex) {
      throw InvalidArgument("vertex " + std::to_string(v) +
                            " is watched and has no tissue; watch others first");
    }
    built.watched_places.push_back(built.place_of_vertex[parts_->ids.vertices[v]]);
  }
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    data.fetch_state(copy);
  }
  parts_->ids.version = data.last_topology_version + 1;
  move_state(data, built, parts_->ids);
  std::swap(data, built);
  parts_->is_used = true;
  return parts_->ids;
}

}  // namespace pbdsurg
