// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/topology_edit.h"

#include <algorithm>
#include <cmath>
#include <memory_resource>
#include <string>

#include "pbdsurg/core/error.h"

#include "edit/edit_checks.h"
#include "edit/fingerprint.h"
#include "edit/part_tissue.h"
#include "edit/removal.h"
#include "edit/split_tets.h"
#include "solver/add_bodies.h"
#include "solver/backend.h"
#include "solver/growth.h"
#include "solver/neo_hookean_record.h"
#include "solver/solver_data.h"

namespace pbdsurg {
namespace {

void scale_limit(SolverData& data, Index edge, float factor) {
  if (data.strain_limits.is_alive(edge)) {
    const float limit = data.strain_limits.record(edge).parameters[StrainLimitConstraint::kLimit];
    data.strain_limits.set_parameter(edge, StrainLimitConstraint::kLimit, limit * factor);
    data.log_constraint(PhaseKind::strain_limit, edge);
  }
}

// A strain limit keeps its share of the rest length.
void set_rest_length(SolverData& data, const RestLengthChange& change) {
  const Index distance = data.distance_ids.of_edge(change.edge);
  const float before = data.distances.record(distance).parameters[DistanceConstraint::kRest];
  scale_limit(data, change.edge, change.rest_length / before);
  data.distances.set_parameter(distance, DistanceConstraint::kRest, change.rest_length);
  data.log_constraint(PhaseKind::distance, distance);
  set_vertex_rest_length(data, distance, change.rest_length);
}

void set_rest_volume(SolverData& data, const RestVolumeChange& change) {
  if (data.neo_hookeans.is_alive(change.tet)) {
    // an edge has no rest length of its own: where all n tetrahedra around it change alike, n times
    // the n-th root makes it follow their sides
    const double ratio =
        double{change.rest_volume} / rest_volume(data.neo_hookeans.record(change.tet));
    for (const Index edge : data.tet_edges[change.tet]) {
      scale_limit(data, edge,
                  static_cast<float>(std::pow(ratio, 1.0 / (3 * data.edge_tets[edge]))));
    }
    set_rest_volume(data.neo_hookeans, change.tet, change.rest_volume);
    data.log_constraint(PhaseKind::neo_hookean, change.tet);
  } else {
    data.volumes.set_parameter(change.tet, VolumeConstraint::kRest, change.rest_volume);
    data.log_constraint(PhaseKind::volume, change.tet);
  }
  set_vertex_rest_volume(data, change.tet, change.rest_volume);
}

void check_participants(std::span<EditParticipant* const> participants) {
  for (std::size_t i = 0; i < participants.size(); ++i) {
    const auto others = participants.first(i);
    if (participants[i] == nullptr || std::ranges::find(others, participants[i]) != others.end()) {
      throw InvalidArgument("participant " + std::to_string(i) +
                            " is null or takes part already; each must be named once");
    }
  }
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
  check_participants(participants);
  const std::span<const Index> stopping = check_edit(data, edit);
  for (const EditParticipant* participant : participants) {
    participant->validate(solver, edit);
  }

  const bool brings_bodies = !edit.new_bodies.bodies().empty();
  const bool brings_vertices = brings_bodies || !edit.new_vertices.empty();
  std::pmr::vector<Index> ends(data.scratch.get());
  for (const NewVertex& vertex : edit.new_vertices) {
    ends.insert(ends.end(), {vertex.first, vertex.second});
  }
  if (brings_vertices) {
    data.finish_running_step();  // all else leaves it alone
  }
  prefetch_removals(data, edit.remove_tets);
  data.begin_edit(stopping, ends);
  clear(result);
  result.first_new_vertex = static_cast<Index>(data.particles.size());
  result.first_new_tet = static_cast<Index>(data.tets.size());
  result.first_new_link = static_cast<Index>(data.links.size());
  result.first_new_edge = static_cast<Index>(data.edges.size());
  result.first_new_body = static_cast<Index>(data.bodies.size());
  for (const RestLengthChange& change : edit.rest_lengths) {
    set_rest_length(data, change);
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    set_rest_volume(data, change);
  }
  for (const Index link : edit.remove_links) {
    remove_link(data, link, result);
  }
  for (const NewVertex& vertex : edit.new_vertices) {
    add_vertex(data, vertex.first, vertex.second, vertex.share);
  }
  move_links(data, edit);
  for (const Index t : edit.remove_tets) {
    remove_tet(data, t, result);
  }
  for (const Index body : edit.remove_bodies) {
    remove_body(data, body, result);
  }
  move_corners(data, edit, result);
  replace_parents(data, edit, result);
  sum_masses(data);
  release_vertices(data, result);
  add_bodies(data, edit.new_bodies);
  for (const Link& link : edit.new_links) {
    add_link(data, link);
  }
  const Index first_of_bodies =
      result.first_new_vertex + static_cast<Index>(edit.new_vertices.size());
  for (Link link : edit.new_bodies.links()) {
    link.first += first_of_bodies;
    link.second += first_of_bodies;
    add_link(data, link);
  }
  if (brings_vertices || !edit.new_tets.empty() || !edit.new_links.empty()) {
    finish_growth(data);
  } else {
    refresh_vertices(data);
  }
  data.update_plan(!data.journal.releases.empty());
  result.topology_version = data.last_topology_version + 1;
  data.end_edit(fingerprint_of(edit, result));
  data.journal.participants.assign(participants.begin(), participants.end());
  data.backend->follow_edit(data);

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
  if (!std::ranges::equal(data.journal.participants, participants)) {
    throw InvalidArgument(
        "an edit is taken back with the participants that it had, in their order");
  }
  for (const EditParticipant* participant : participants) {
    participant->validate(solver, {});  // each is where apply() left it, unless it was moved from
  }
  const auto is_of_edit = [&](Index place) {  // new vertices have the places that follow
    return static_cast<std::size_t>(place) >= data.journal.vertex_count;
  };
  if (std::ranges::any_of(data.watched_places, is_of_edit)) {
    throw InvalidArgument("a vertex that the edit brought is watched; watch others first");
  }
  data.undo_edit();
  data.backend->follow_edit(data);
  for (std::size_t i = participants.size(); i-- > 0;) {
    participants[i]->undo(solver, edit, result);
  }
}

}  // namespace pbdsurg
