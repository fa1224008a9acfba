// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/version.h"

namespace cholecystectomy {
namespace {

using Json = nlohmann::ordered_json;

Json bodies_of(const pbdsurg::Solver& solver) {
  Json bodies = Json::array();
  for (const pbdsurg::Body& body : solver.tissue().bodies()) {
    const auto edges = std::count_if(solver.tissue().edges().begin(), solver.tissue().edges().end(),
                                     [&](const pbdsurg::Edge& edge) {
                                       return edge[0] >= body.first_vertex &&
                                              edge[0] < body.first_vertex + body.vertex_count;
                                     });
    bodies.push_back({{"name", body.name},
                      {"vertices", body.vertex_count},
                      {"edges", edges},
                      {"tets", body.tet_count}});
  }
  return bodies;
}

Json joints_of(const SurgicalScene& scene) {
  Json joints = Json::array();
  for (const JoinedPair& pair : scene.joined) {
    joints.push_back({{"first", pbdsurg::name_of(pair.first)},
                      {"second", pbdsurg::name_of(pair.second)},
                      {"links", pair.link_count},
                      {"fibres", pair.fibre_count}});
  }
  return joints;
}

Json warnings_of(const std::vector<Warning>& warnings) {
  Json result = Json::array();
  for (const Warning& warning : warnings) {
    result.push_back({{"code", warning.code},
                      {"text", warning.text},
                      {"value", warning.value ? Json(*warning.value) : Json(nullptr)}});
  }
  return result;
}

Json colors_of(const pbdsurg::StepPlan& plan) {
  const auto count = [&](pbdsurg::PhaseKind kind) {
    return std::count_if(plan.phases.begin(), plan.phases.end(),
                         [&](const pbdsurg::Phase& phase) { return phase.kind == kind; });
  };
  return {{"distance", count(pbdsurg::PhaseKind::distance)},
          {"volume", count(pbdsurg::PhaseKind::volume)},
          {"joint", count(pbdsurg::PhaseKind::joint)},
          {"vertex", count(pbdsurg::PhaseKind::vertex)},
          {"stiff_link", count(pbdsurg::PhaseKind::stiff_link)},
          {"attachment", count(pbdsurg::PhaseKind::attachment)},
          {"contact", count(pbdsurg::PhaseKind::contact)},
          {"total", plan.phases.size()}};
}

Json build() {
  return {{"version", pbdsurg::version()}, {"build_id", pbdsurg::build_id()}};
}

// What became of the strands between organs; each is one link.
Json strands_of(const pbdsurg::ConnectiveTissue& connections) {
  Json result{{"made", connections.strands().size()}, {"whole", connections.whole_count()}};
  using pbdsurg::StrandLoss;
  for (const auto& [name, cause] :
       {std::pair("torn", StrandLoss::torn), std::pair("parted_by_heat", StrandLoss::removed),
        std::pair("without_tissue", StrandLoss::without_tissue)}) {
    result[name] = std::count_if(
        connections.events().begin(), connections.events().end(),
        [cause = cause](const pbdsurg::StrandEvent& event) { return event.cause == cause; });
  }
  return result;
}

// Where the energy went that the hook delivered; what it drove through the rest of the body is left
// out.
Json ledger_of(const pbdsurg::Cautery& cautery) {
  const pbdsurg::HeatLedger& heat = cautery.field().ledger();
  const double links = cautery.link_energy_spent(), electrode = cautery.electrode_energy();
  const double tissue = heat.sensible + heat.latent + heat.removed + heat.surface + heat.perfusion;
  return {{"in_j", heat.in + links + electrode},
          {"sensible_j", heat.sensible},
          {"latent_j", heat.latent},
          {"removed_j", heat.removed},
          {"surface_j", heat.surface},
          {"perfusion_j", heat.perfusion},
          {"links_j", links},
          {"electrode_j", electrode},
          {"error_j", heat.in - tissue}};
}

Json range_of(const Range& range) {
  if (range.count == 0) {
    return nullptr;
  }
  return {{"least", range.least},
          {"mean", range.sum / static_cast<double>(range.count)},
          {"most", range.most}};
}

Json burn_of(const Totals& totals) {
  return {{"steps_with_current", totals.burn_power.count},
          {"steps_with_sparks", totals.sparks},
          {"steps_not_converged", totals.unconverged},
          {"power_w", range_of(totals.burn_power)},
          {"voltage_v", range_of(totals.burn_voltage)},
          {"resistance_ohm", range_of(totals.burn_resistance)},
          {"hottest_degc", totals.hottest},
          {"tets_torn_by_steam", totals.tets_torn_by_steam},
          {"tets_deferred_max", totals.tets_deferred_max}};
}

// Distance left at the times of figure 9, mm, at the first step not before each.
Json recovery_of(const Recovery& recovery) {
  Json result = Json::object();
  if (recovery.distances.empty()) {
    return result;
  }
  for (const int ms : {0, 25, 50, 100}) {
    for (std::size_t i = 0; i < recovery.times.size(); ++i) {
      if (recovery.times[i] >= 1e-3 * ms - 1e-6) {
        result[std::to_string(ms)] = 1e3 * recovery.distances[i];
        break;
      }
    }
  }
  result["end"] = 1e3 * recovery.distances.back();
  return result;
}

}  // namespace

void write_report(const std::filesystem::path& path, const Simulation& simulation,
                  const Course& course, const ReportNotes& notes) {
  const pbdsurg::Solver& solver = simulation.solver;
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(solver.state_hash()));

  Json report;
  report["bodies"] = bodies_of(solver);
  report["organ_files"] = notes.organs;
  report["joints"] = joints_of(simulation.scene);
  report["links"] = solver.tissue().links().size();
  report["membrane_links"] = simulation.scene.membrane_link_count;
  report["plan"] = solver.plan().name;
  report["projection"] =
      solver.options().mode == pbdsurg::ProjectionMode::fraction ? "fraction" : "compliance";
  report["substeps"] = solver.options().substeps;
  report["iterations"] = solver.options().iterations;
  report["time_step_s"] = simulation.time_step;
  report["steps"] = simulation.totals.steps;
  report["simulated_s"] = simulation.time();
  if (course.is_interrupted) {
    report["interrupted_at_s"] = simulation.time();
  }
  report["colors"] = colors_of(solver.plan());
  report["backend"] = solver.backend_name();
  report["build"] = build();
  report["seed"] = notes.seed;
  report["touching_steps"] = {{"grasper", simulation.totals.grasper_touches},
                              {"hook", simulation.totals.hook_touches}};
  report["tets_deleted"] = simulation.totals.tets_deleted;
  report["links_cut"] = simulation.totals.links_cut;
  report["strands"] = strands_of(simulation.connections);
  report["energy_in_j"] = simulation.energy_in();
  report["energy_ledger"] = ledger_of(simulation.cautery);
  report["cautery"] = burn_of(simulation.totals);
  report["residual_max"] = simulation.totals.residual_max;
  report["residual_last"] = simulation.totals.residual_last;
  report["inverted_tets_max"] = simulation.totals.inverted_tets_max;
  report["dropped_contacts"] = simulation.totals.dropped_contacts;
  report["held_force_n"] = course.held_force;
  report["recovery_mm"] = recovery_of(course.recovery);
  report["state_hash"] = hash;
  report["warnings"] = warnings_of(notes.warnings);
  report["files"] = notes.files;
  report["stages_ms"] = simulation.times;

  std::ofstream file(path);
  file << report.dump(2) << '\n';
  file.close();
  if (!file) {
    throw pbdsurg::FileError(path.string() + ": cannot be written");
  }
}

}  // namespace cholecystectomy
