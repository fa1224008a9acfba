// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/topology_edit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

#include "edit/fingerprint.h"
#include "solver/neo_hookean_record.h"
#include "solver/solver_data.h"

namespace pbdsurg {
namespace {

std::string name_of(const char* what, Index id) {
  return std::string(what) + " " + std::to_string(id);
}

// Ids must be in range, alive and listed once.
template <class IsAlive>
void check_ids(const char* what, std::vector<Index> ids, std::size_t count, IsAlive is_alive) {
  for (const Index id : ids) {
    if (id < 0 || static_cast<std::size_t>(id) >= count) {
      throw InvalidArgument(name_of(what, id) + " does not exist; ids must be in [0, " +
                            std::to_string(count) + ")");
    }
    if (!is_alive(id)) {
      throw InvalidArgument(name_of(what, id) + " was removed before");
    }
  }
  std::sort(ids.begin(), ids.end());
  const auto twice = std::adjacent_find(ids.begin(), ids.end());
  if (twice != ids.end()) {
    throw InvalidArgument(name_of(what, *twice) + " is listed twice in one edit");
  }
}

void check_rest(const char* what, Index id, const char* quantity, float value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(name_of(what, id) + ": the new " + quantity + " is " +
                          std::to_string(value) + "; it must be positive and finite");
  }
}

void validate(const SolverData& data, const TopologyEdit& edit) {
  if (!edit.new_vertices.empty() || !edit.corner_moves.empty() || !edit.link_moves.empty() ||
      !edit.new_tets.empty() || !edit.new_links.empty()) {
    throw InvalidArgument("under construction on this branch");
  }
  const auto tet_alive = [&](Index t) { return data.tet_alive[t]; };
  check_ids("tet", edit.remove_tets, data.tets.size(), tet_alive);
  check_ids("link", edit.remove_links, data.links.size(),
            [&](Index l) { return data.distances.is_alive(data.distance_of_link(l)); });

  std::vector<Index> edges, tets;
  for (const RestLengthChange& change : edit.rest_lengths) {
    check_rest("edge", change.edge, "rest length", change.rest_length);
    edges.push_back(change.edge);
  }
  check_ids("edge", edges, data.edges.size(), [&](Index e) { return data.edge_tets[e] > 0; });
  for (const Index e : edges) {
    if (!data.distances.is_alive(e)) {
      throw InvalidArgument(name_of("edge", e) +
                            " belongs to a Neo-Hookean body, whose edges have no rest length");
    }
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    check_rest("tet", change.tet, "rest volume", change.rest_volume);
    tets.push_back(change.tet);
  }
  check_ids("tet", tets, data.tets.size(), tet_alive);
  for (const Index t : tets) {
    if (!data.volumes.is_alive(t) && !data.neo_hookeans.is_alive(t)) {
      throw InvalidArgument(name_of("tet", t) + " belongs to a body without volume constraints");
    }
  }
}

// A strain limit keeps its share of the rest length.
void set_rest_length(SolverData& data, const RestLengthChange& change) {
  if (data.strain_limits.is_alive(change.edge)) {
    const float before = data.distances.record(change.edge).parameters[DistanceConstraint::kRest];
    const float limit =
        data.strain_limits.record(change.edge).parameters[StrainLimitConstraint::kLimit];
    data.strain_limits.set_parameter(change.edge, StrainLimitConstraint::kLimit,
                                     limit * (change.rest_length / before));
    data.log_constraint(PhaseKind::strain_limit, change.edge);
  }
  data.distances.set_parameter(change.edge, DistanceConstraint::kRest, change.rest_length);
  data.log_constraint(PhaseKind::distance, change.edge);
}

void set_rest_volume(SolverData& data, const RestVolumeChange& change) {
  if (data.neo_hookeans.is_alive(change.tet)) {
    set_rest_volume(data.neo_hookeans, change.tet, change.rest_volume);
    data.log_constraint(PhaseKind::neo_hookean, change.tet);
  } else {
    data.volumes.set_parameter(change.tet, VolumeConstraint::kRest, change.rest_volume);
    data.log_constraint(PhaseKind::volume, change.tet);
  }
}

void remove_link(SolverData& data, Index link, EditResult& result) {
  data.distances.remove(data.distance_of_link(link));
  data.log_constraint(PhaseKind::distance, data.distance_of_link(link));
  remove_vertex_spring(data, data.distance_of_link(link));
  result.links.push_back(link);
}

void remove_tet(SolverData& data, Index t, EditResult& result) {
  data.tet_alive[t] = false;
  data.journal.tets.push_back(t);
  data.log_tet(t);
  remove_vertex_tet(data, t);
  result.tets.push_back(t);
  for (const Index edge : data.tet_edges[t]) {
    if (--data.edge_tets[edge] == 0) {
      if (data.distances.is_alive(edge)) {
        data.distances.remove(edge);
        data.log_constraint(PhaseKind::distance, edge);
      }
      if (data.strain_limits.is_alive(edge)) {
        data.strain_limits.remove(edge);
        data.log_constraint(PhaseKind::strain_limit, edge);
      }
      remove_vertex_spring(data, edge);
      result.edges.push_back(edge);
    }
  }
  if (data.volumes.is_alive(t)) {
    data.remove_volume(t);
  }
  if (data.neo_hookeans.is_alive(t)) {
    data.neo_hookeans.remove(t);
    data.log_constraint(PhaseKind::neo_hookean, t);
  }
  for (const Index v : data.tets[t]) {
    if (--data.vertex_tets[v] == 0) {
      data.set_mass(v, 0);
      result.vertices.push_back(v);
    } else {
      data.set_mass(v, data.vertex_masses[v] - data.tet_masses[t] / 4);
    }
  }
}

// Links and tools let go of vertices without tissue.
void release_vertices(SolverData& data, EditResult& result) {
  if (result.vertices.empty()) {
    return;
  }
  for (const Index v : result.vertices) {
    for (const Index link : data.vertex_links[v]) {
      if (data.distances.is_alive(data.distance_of_link(link))) {
        remove_link(data, link, result);
      }
    }
  }
  data.release_dead_vertices();
}

// Vertices all of whose tetrahedra an edit removes, ascending.
std::vector<Index> find_stopping(const SolverData& data, const TopologyEdit& edit) {
  std::vector<Index> corners;
  for (const Index t : edit.remove_tets) {
    corners.insert(corners.end(), data.tets[t].begin(), data.tets[t].end());
  }
  std::ranges::sort(corners);
  std::vector<Index> stopping;
  for (auto first = corners.begin(); first != corners.end();) {
    const auto last = std::upper_bound(first, corners.end(), *first);
    if (last - first == data.vertex_tets[*first]) {
      stopping.push_back(*first);
    }
    first = last;
  }
  return stopping;
}

}  // namespace

EditResult apply_edit(Solver& solver, const TopologyEdit& edit,
                      std::span<EditParticipant* const> participants) {
  SolverData& data = solver_data(solver);
  data.finish_running_step();
  validate(data, edit);
  for (const EditParticipant* participant : participants) {
    participant->validate(solver, edit);
  }

  data.begin_edit(find_stopping(data, edit));
  EditResult result;
  for (const RestLengthChange& change : edit.rest_lengths) {
    set_rest_length(data, change);
    set_vertex_rest_length(data, change.edge, change.rest_length);
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    set_rest_volume(data, change);
    set_vertex_rest_volume(data, change.tet, change.rest_volume);
  }
  for (const Index link : edit.remove_links) {
    remove_link(data, link, result);
  }
  for (const Index t : edit.remove_tets) {
    remove_tet(data, t, result);
  }
  release_vertices(data, result);
  refresh_vertices(data);
  data.rebuild_plan();
  result.topology_version = data.last_topology_version + 1;
  data.end_edit(fingerprint_of(edit, result));

  for (EditParticipant* participant : participants) {
    participant->apply(solver, edit, result);
  }
  return result;
}

void undo_edit(Solver& solver, const TopologyEdit& edit, const EditResult& result,
               std::span<EditParticipant* const> participants) {
  SolverData& data = solver_data(solver);
  data.finish_running_step();
  if (!data.journal.is_open || data.journal.fingerprint != fingerprint_of(edit, result)) {
    throw InvalidArgument("the edit that made topology version " +
                          std::to_string(result.topology_version) +
                          " is not the last one of this solver, or was taken back; it is at " +
                          std::to_string(data.topology_version));
  }
  data.undo_edit();
  for (std::size_t i = participants.size(); i-- > 0;) {
    participants[i]->undo(solver, edit, result);
  }
}

}  // namespace pbdsurg
