// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cautery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

#include "core/segment.h"
#include "solver/load_store.h"

namespace pbdsurg {
namespace {

void check_range(const char* what, double value, double low, double high) {
  if (!(value >= low) || !(value <= high)) {
    throw InvalidArgument(std::string(what) + " is " + std::to_string(value) + "; it must be in [" +
                          std::to_string(low) + ", " + std::to_string(high) + "]");
  }
}

// Rest values follow the water in steps of one percent, so that an edit a step stays small.
constexpr float kLeastChange = 0.01F;

}  // namespace

Cautery::Cautery(const Solver& solver, std::span<const ThermalBody> bodies,
                 const CauteryOptions& options)
    : options_(options), field_(solver, bodies) {
  if (!(options.contact_radius > 0) || !std::isfinite(options.contact_radius)) {
    throw InvalidArgument("contact_radius is " + std::to_string(options.contact_radius) +
                          " m; it must be positive and finite");
  }
  if (!(options.link_energy > 0) || !std::isfinite(options.link_energy)) {
    throw InvalidArgument("link_energy is " + std::to_string(options.link_energy) +
                          " J; it must be positive and finite");
  }
  if (!(options.link_share > 0) || !std::isfinite(options.link_share)) {
    throw InvalidArgument("link_share is " + std::to_string(options.link_share) +
                          "; it must be positive and finite");
  }
  check_range("dry_water", options.dry_water, 0, 1);
  check_range("largest_shrinkage", options.largest_shrinkage, 0, 0.9);
  for (const ThermalBody& body : bodies) {
    if (!(body.tissue.water_fraction > 0)) {
      throw InvalidArgument("the tissue of body '" + solver.body(body.body).name +
                            "' has no water; without it nothing would ever vaporise");
    }
  }
  link_doses_.resize(solver.links().size());
}

double Cautery::shrunk(double water) const {
  return 1 - options_.largest_shrinkage * (1 - water);
}

std::vector<Cautery::Share> Cautery::find_touched_vertices(
    std::span<const Eigen::Vector3f> positions, const Eigen::Vector3f& tip) const {
  const ThermalMesh& mesh = field_.mesh();
  const auto is_wet = [&](Index v) { return field_.water()[v] > options_.dry_water; };
  std::vector<double> nearness(positions.size(), 0.0);
  bool touches_dry = false;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const double distance = (positions[v] - tip).norm();
    if (distance < options_.contact_radius && mesh.has_tissue(v)) {
      nearness[v] = 1 - distance / options_.contact_radius;
      touches_dry = touches_dry || !is_wet(v);
    }
  }
  if (touches_dry) {
    // through dry tissue the current goes on to the wet tissue behind it
    std::vector<double> behind(nearness.size(), 0.0);
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      if (!mesh.is_alive(t)) {
        continue;
      }
      for (const Index near : mesh.tets()[t]) {
        if (!(nearness[near] > 0) || is_wet(near)) {
          continue;
        }
        for (const Index far : mesh.tets()[t]) {
          if (is_wet(far)) {
            behind[far] = std::max(behind[far], nearness[near]);
          }
        }
      }
    }
    for (std::size_t v = 0; v < behind.size(); ++v) {
      nearness[v] = std::max(nearness[v], behind[v]);
    }
  }
  std::vector<Share> touched;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (nearness[v] > 0 && is_wet(v)) {
      touched.push_back({v, nearness[v]});
    }
  }
  return touched;
}

std::vector<Cautery::Share> Cautery::find_touched_links(const Solver& solver,
                                                        std::span<const Eigen::Vector3f> positions,
                                                        const Eigen::Vector3f& tip) const {
  std::vector<Share> touched;
  for (std::size_t l = 0; l < solver.links().size(); ++l) {
    const Link& link = solver.links()[l];
    if (!solver.is_link_alive(static_cast<Index>(l))) {
      continue;
    }
    const Vec3<float> away =
        closest_on_segment(load(positions[link.first]), load(positions[link.second]), load(tip)) -
        load(tip);
    const double distance = std::sqrt(dot(away, away));
    if (distance < options_.contact_radius) {
      touched.push_back(
          {static_cast<Index>(l), options_.link_share * (1 - distance / options_.contact_radius)});
    }
  }
  return touched;
}

HeatState Cautery::state(Index tet) const {
  const ThermalMesh& mesh = field_.mesh();
  if (!mesh.is_alive(tet)) {
    return mesh.tissue_of_tet(tet) == kInvalidIndex ? HeatState::normal : HeatState::vaporised;
  }
  double water = 0;
  for (const Index v : mesh.tets()[tet]) {
    water += field_.water()[v] / 4;
  }
  return heat_state(RemovalRule::water, field_.boiled_vertices(tet), water, options_.dry_water);
}

void Cautery::collect_changes(const Solver& solver, TopologyEdit& edit) const {
  const ThermalMesh& mesh = field_.mesh();
  std::vector<Index> shrinking;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    if (!mesh.is_alive(t)) {
      continue;
    }
    const HeatState now = state(t);
    if (now == HeatState::vaporised) {
      edit.remove_tets.push_back(t);
      continue;
    }
    if (now != HeatState::burning) {
      continue;
    }
    double water = 0;
    std::array<bool, 4> boiled;
    for (std::size_t k = 0; k < 4; ++k) {
      const Index v = mesh.tets()[t][k];
      water += field_.water()[v] / 4;
      boiled[k] = field_.has_boiled(v);
    }
    const Material& material = solver.body(solver.body_of_tet(t)).material;
    const bool is_neo_hookean = material.model == ElasticModel::neo_hookean;
    if (is_neo_hookean || material.has_volume_constraints) {
      const double factor = shrunk(water);
      const auto volume = static_cast<float>(mesh.volume(t) * factor * factor * factor);
      if (volume < (1 - kLeastChange) * solver.rest_volume(t)) {
        edit.rest_volumes.push_back({t, volume});
      }
    }
    for (std::size_t e = 0; e < kTetEdges.size() && !is_neo_hookean; ++e) {
      if (boiled[kTetEdges[e][0]] && boiled[kTetEdges[e][1]]) {
        shrinking.push_back(solver.tet_edges(t)[e]);
      }
    }
  }
  std::sort(shrinking.begin(), shrinking.end());
  shrinking.erase(std::unique(shrinking.begin(), shrinking.end()), shrinking.end());
  for (const Index e : shrinking) {
    const auto [a, b] = solver.edges()[e];
    const double rest_length = (mesh.rest_positions()[a] - mesh.rest_positions()[b]).norm();
    const auto length =
        static_cast<float>(rest_length * shrunk((field_.water()[a] + field_.water()[b]) / 2));
    if (length < (1 - kLeastChange) * solver.rest_length(e)) {
      edit.rest_lengths.push_back({e, length});
    }
  }
}

CauteryReport Cautery::update(Solver& solver, const Eigen::Vector3f& tip, double power, double dt,
                              std::span<EditParticipant* const> participants) {
  if (!tip.allFinite() || !(power >= 0) || !std::isfinite(power) || !(dt > 0) ||
      !std::isfinite(dt)) {
    throw InvalidArgument("cautery with a power of " + std::to_string(power) + " W for " +
                          std::to_string(dt) +
                          " s: the tip must be finite, the power >= 0, the time positive");
  }
  field_.validate(solver, {});
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  CauteryReport report;
  std::vector<Share> touched, links;
  double weight = 0;
  if (power > 0) {
    touched = find_touched_vertices(positions, tip);
    report.contact_vertices = static_cast<Index>(touched.size());
    for (const Share& share : touched) {
      weight += share.weight;
    }
    links = find_touched_links(solver, positions, tip);
    report.contact_links = static_cast<Index>(links.size());
    for (const Share& share : links) {
      weight += share.weight;
    }
  }

  TopologyEdit edit;
  const double energy_before = energy_in();
  std::vector<HeatSource> sources;
  for (const Share& share : touched) {
    sources.push_back({share.id, power * share.weight / weight});
  }
  field_.step(dt, sources);
  collect_changes(solver, edit);
  for (const Share& share : links) {
    // a link takes no more than parts it
    const double energy =
        std::min(power * dt * share.weight / weight, options_.link_energy - link_doses_[share.id]);
    link_doses_[share.id] += energy;
    link_energy_spent_ += energy;
  }
  for (Index l = 0; l < static_cast<Index>(link_doses_.size()); ++l) {
    if (!(link_doses_[l] < options_.link_energy) && solver.is_link_alive(l)) {
      edit.remove_links.push_back(l);
    }
  }
  report.energy = energy_in() - energy_before;

  if (!edit.remove_tets.empty() || !edit.remove_links.empty() || !edit.rest_lengths.empty() ||
      !edit.rest_volumes.empty()) {
    std::vector<EditParticipant*> all(participants.begin(), participants.end());
    if (std::find(all.begin(), all.end(), this) == all.end()) {
      all.push_back(this);
    }
    report.edit = apply_edit(solver, edit, all);
    report.request = std::move(edit);
  }
  return report;
}

void Cautery::validate(const Solver& solver, const TopologyEdit& edit) const {
  field_.validate(solver, edit);
}

void Cautery::apply(const Solver& solver, const TopologyEdit& edit,
                    const EditResult& result) noexcept {
  field_.apply(solver, edit, result);
  link_doses_.resize(solver.links().size());
}

void Cautery::undo(const Solver& solver, const TopologyEdit& edit,
                   const EditResult& result) noexcept {
  field_.undo(solver, edit, result);
  link_doses_.resize(solver.links().size());
}

double Cautery::energy_in() const noexcept {
  return field_.ledger().in + link_energy_spent_;
}

}  // namespace pbdsurg
