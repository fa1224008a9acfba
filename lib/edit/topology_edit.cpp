// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/topology_edit.h"

#include <string>

#include "pbdsurg/core/error.h"

#include "edit/edit_checks.h"
#include "edit/fingerprint.h"
#include "solver/growth.h"
#include "solver/neo_hookean_record.h"
#include "solver/solver_data.h"

namespace pbdsurg {
namespace {

// A strain limit keeps its share of the rest length.
void set_rest_length(SolverData& data, const RestLengthChange& change) {
  const Index distance = data.distance_ids.of_edge(change.edge);
  if (data.strain_limits.is_alive(change.edge)) {
    const float before = data.distances.record(distance).parameters[DistanceConstraint::kRest];
    const float limit =
        data.strain_limits.record(change.edge).parameters[StrainLimitConstraint::kLimit];
    data.strain_limits.set_parameter(change.edge, StrainLimitConstraint::kLimit,
                                     limit * (change.rest_length / before));
    data.log_constraint(PhaseKind::strain_limit, change.edge);
  }
  data.distances.set_parameter(distance, DistanceConstraint::kRest, change.rest_length);
  data.log_constraint(PhaseKind::distance, distance);
  set_vertex_rest_length(data, distance, change.rest_length);
}

void set_rest_volume(SolverData& data, const RestVolumeChange& change) {
  if (data.neo_hookeans.is_alive(change.tet)) {
    set_rest_volume(data.neo_hookeans, change.tet, change.rest_volume);
    data.log_constraint(PhaseKind::neo_hookean, change.tet);
  } else {
    data.volumes.set_parameter(change.tet, VolumeConstraint::kRest, change.rest_volume);
    data.log_constraint(PhaseKind::volume, change.tet);
  }
  set_vertex_rest_volume(data, change.tet, change.rest_volume);
}

void remove_link(SolverData& data, Index link, EditResult& result) {
  const Index distance = data.distance_ids.of_link(link);
  data.distances.remove(distance);
  data.log_constraint(PhaseKind::distance, distance);
  remove_vertex_spring(data, distance);
  data.vertex_links.erase(data.links[link].first, link);
  data.vertex_links.erase(data.links[link].second, link);
  data.journal.links.push_back(link);
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
      const Index distance = data.distance_ids.of_edge(edge);
      if (data.distances.is_alive(distance)) {
        data.distances.remove(distance);
        data.log_constraint(PhaseKind::distance, distance);
      }
      if (data.strain_limits.is_alive(edge)) {
        data.strain_limits.remove(edge);
        data.log_constraint(PhaseKind::strain_limit, edge);
      }
      remove_vertex_spring(data, distance);
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
    data.vertex_tets.erase(v, t);
    if (data.vertex_tets[v].empty()) {
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
    while (!data.vertex_links[v].empty()) {
      remove_link(data, data.vertex_links[v].front(), result);
    }
  }
  data.release_dead_vertices();
}

void clear(EditResult& result) {
  for (std::vector<Index>* const ids :
       {&result.tets, &result.edges, &result.links, &result.vertices}) {
    ids->clear();
  }
}

}  // namespace

EditResult apply_edit(Solver& solver, const TopologyEdit& edit,
                      std::span<EditParticipant* const> participants) {
  EditResult result;
  apply_edit(solver, edit, result, participants);
  return result;
}

void apply_edit(Solver& solver, const TopologyEdit& edit, EditResult& result,
                std::span<EditParticipant* const> participants) {
  SolverData& data = solver_data(solver);
  data.finish_running_step();
  check_edit(data, edit);
  for (const EditParticipant* participant : participants) {
    participant->validate(solver, edit);
  }

  find_stopping(data, edit, data.edit_buffer);
  data.begin_edit(data.edit_buffer);
  clear(result);
  result.first_new_vertex = static_cast<Index>(data.particles.size());
  result.first_new_tet = static_cast<Index>(data.tets.size());
  result.first_new_link = static_cast<Index>(data.links.size());
  result.first_new_edge = static_cast<Index>(data.edges.size());
  for (const RestLengthChange& change : edit.rest_lengths) {
    set_rest_length(data, change);
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    set_rest_volume(data, change);
  }
  for (const Index link : edit.remove_links) {
    remove_link(data, link, result);
  }
  for (const Index t : edit.remove_tets) {
    remove_tet(data, t, result);
  }
  release_vertices(data, result);
  for (const Link& link : edit.new_links) {
    add_link(data, link);
  }
  if (edit.new_links.empty()) {
    refresh_vertices(data);
  } else {
    finish_growth(data);
  }
  data.rebuild_plan();
  result.topology_version = data.last_topology_version + 1;
  data.end_edit(fingerprint_of(edit, result));

  for (EditParticipant* participant : participants) {
    participant->apply(solver, edit, result);
  }
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
