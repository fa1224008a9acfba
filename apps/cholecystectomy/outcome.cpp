// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/outcome.h"

#include <algorithm>
#include <string>
#include <vector>

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::Solver;

Index body_with(const Solver& solver, Index vertex) {
  const auto bodies = solver.tissue().bodies();
  const auto next =
      std::upper_bound(bodies.begin(), bodies.end(), vertex,
                       [](Index v, const pbdsurg::Body& body) { return v < body.first_vertex; });
  return static_cast<Index>(next - bodies.begin()) - 1;
}

// Which bodies have a fixed vertex, or hang on such a body by whole strands. [body]
std::vector<bool> find_held(const Simulation& simulation) {
  const Solver& solver = simulation.solver;
  std::vector<bool> is_held(solver.tissue().bodies().size(), false);
  for (std::size_t b = 0; b < is_held.size(); ++b) {
    const pbdsurg::Body& body = solver.tissue().bodies()[b];
    for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
      is_held[b] = is_held[b] || simulation.scene.scene.is_fixed(v);
    }
  }
  const pbdsurg::ConnectiveTissue& connections = simulation.connections;
  for (std::size_t round = 0; round < is_held.size(); ++round) {  // no way is longer
    for (std::size_t s = 0; s < connections.strands().size(); ++s) {
      if (connections.is_whole(static_cast<Index>(s))) {
        const pbdsurg::Link& link = solver.tissue().links()[connections.strands()[s].first_link];
        const Index first = body_with(solver, link.first), second = body_with(solver, link.second);
        is_held[first] = is_held[second] = is_held[first] || is_held[second];
      }
    }
  }
  return is_held;
}

void judge_organs(const Simulation& simulation, std::vector<Warning>& warnings) {
  const Solver& solver = simulation.solver;
  const std::vector<bool> is_held = find_held(simulation);
  for (std::size_t b = 0; b < is_held.size(); ++b) {
    const pbdsurg::Body& body = solver.tissue().bodies()[b];
    Index tets = 0;
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      tets += solver.tissue().is_tet_alive(t) ? 1 : 0;
    }
    if (tets == 0) {
      warnings.push_back({"organ_lost", "nothing is left of the " + body.name, 0, true});
    } else if (!is_held[b]) {
      warnings.push_back(
          {"organ_lost", "the " + body.name + " fell off: nothing holds it any more", tets, true});
    }
  }
}

}  // namespace

std::vector<Warning> judge(const Simulation& simulation, const Course& course) {
  std::vector<Warning> warnings;
  const Totals& totals = simulation.totals;
  if (!course.failure.empty()) {
    warnings.push_back(
        {"ended_early", "the operation ended early: " + course.failure, simulation.time(), true});
  }
  if (!course.is_interrupted) {
    if (totals.grasper_touches == 0) {
      warnings.push_back({"never_touched", "the grasper never touched anything", 0, true});
    }
    if (totals.hook_touches == 0) {
      warnings.push_back({"never_touched", "the hook never touched anything", 0, true});
    }
    const auto events = simulation.connections.events();
    const bool parted = std::any_of(events.begin(), events.end(), [](const auto& event) {
      return event.cause == pbdsurg::StrandLoss::removed;
    });
    if (totals.tets_deleted == 0 && !parted) {
      warnings.push_back(
          {"nothing_burnt", "the hook burnt nothing away", simulation.energy_in(), true});
    }
  }
  judge_organs(simulation, warnings);
  const Index inverted = totals.inverted_tets_max;
  if (100 * static_cast<std::int64_t>(inverted) >
      static_cast<std::int64_t>(simulation.scene.scene.tets().size())) {
    warnings.push_back({"inverted_tets",
                        "up to " + std::to_string(inverted) +
                            " tetrahedra were inverted at one time, more than one in a hundred; "
                            "does `pbdsurg mesh check` find slivers in an organ of yours?",
                        inverted});
  }
  if (totals.refused_edits > 0) {
    warnings.push_back(
        {"edits_refused", totals.first_refusal, static_cast<double>(totals.refused_edits)});
  }
  return warnings;
}

}  // namespace cholecystectomy
