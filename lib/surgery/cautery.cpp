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

Cautery::Cautery(const Solver& solver, std::span<const CauteryBody> bodies,
                 const CauteryOptions& options)
    : followed_(solver), options_(options), rest_volumes_(bodies.size()) {
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
  if (!solver.bodies().empty()) {
    const Body& last = solver.bodies().back();
    if (solver.vertex_count() > last.first_vertex + last.vertex_count ||
        static_cast<Index>(solver.tets().size()) > last.first_tet + last.tet_count) {
      throw InvalidArgument("edits have split tissue; a cautery must be made before");
    }
  }
  for (const CauteryBody& entry : bodies) {
    const Body& body = solver.body(entry.body);
    if (std::any_of(bodies_.begin(), bodies_.end(),
                    [&](const Body& other) { return other.name == body.name; })) {
      throw InvalidArgument("body '" + body.name + "' is given twice");
    }
    if (entry.mesh == nullptr) {
      throw InvalidArgument("no mesh is given for body '" + body.name + "'");
    }
    if (!(entry.tissue.water_fraction > 0)) {
      throw InvalidArgument("the tissue of body '" + body.name +
                            "' has no water; without it nothing would ever vaporise");
    }
    if (entry.mesh->vertex_count() != body.vertex_count ||
        entry.mesh->tet_count() != body.tet_count) {
      throw InvalidArgument("the mesh given for body '" + body.name + "' has " +
                            std::to_string(entry.mesh->tet_count()) + " tets; the body has " +
                            std::to_string(body.tet_count));
    }
    bodies_.push_back(body);
    fields_.emplace_back(*entry.mesh, entry.tissue, body);
  }
  EditResult gone;
  for (Index t = 0; t < static_cast<Index>(solver.tets().size()); ++t) {
    if (!solver.is_tet_alive(t)) {
      gone.tets.push_back(t);
    }
  }
  for (HeatField& field : fields_) {
    field.apply(solver, {}, gone);
  }
  follow_sizes(solver);
}

// Rest values and doses of what is new, none of what is no more. Rest values are those of the rest
// mesh, which is what heat shrinks from.
void Cautery::follow_sizes(const Solver& solver) noexcept {
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const HeatField& field = fields_[i];
    std::vector<float>& volumes = rest_volumes_[i];
    std::size_t t = volumes.size();
    volumes.resize(field.tets().size());
    for (; t < volumes.size(); ++t) {
      volumes[t] = static_cast<float>(tet_volume(field.rest_positions(), field.tets()[t]));
    }
  }
  std::size_t e = rest_lengths_.size();
  rest_lengths_.resize(solver.edges().size());
  for (; e < rest_lengths_.size(); ++e) {
    for (const HeatField& field : fields_) {
      const Index a = field.find_vertex(solver.edges()[e][0]);
      if (a != kInvalidIndex) {
        const Index b = field.find_vertex(solver.edges()[e][1]);
        rest_lengths_[e] =
            static_cast<float>((field.rest_positions()[a] - field.rest_positions()[b]).norm());
      }
    }
  }
  link_doses_.resize(solver.links().size());
}

double Cautery::shrunk(double water) const {
  return 1 - options_.largest_shrinkage * (1 - water);
}

std::vector<Cautery::Share> Cautery::find_touched_vertices(
    const Solver& solver, std::span<const Eigen::Vector3f> positions, std::size_t i,
    const Eigen::Vector3f& tip) const {
  const HeatField& field = fields_[i];
  const auto is_wet = [&](Index v) { return field.water()[v] > options_.dry_water; };
  const auto vertex_count = static_cast<Index>(field.water().size());
  std::vector<double> nearness(static_cast<std::size_t>(vertex_count), 0.0);
  bool touches_dry = false;
  for (Index v = 0; v < vertex_count; ++v) {
    const double distance = (positions[field.scene_vertex(v)] - tip).norm();
    if (distance < options_.contact_radius && field.has_tissue(v)) {
      nearness[v] = 1 - distance / options_.contact_radius;
      touches_dry = touches_dry || !is_wet(v);
    }
  }
  if (touches_dry) {
    // through dry tissue the current goes on to the wet tissue behind it
    std::vector<double> behind(nearness.size(), 0.0);
    for (Index t = 0; t < static_cast<Index>(field.tets().size()); ++t) {
      if (!solver.is_tet_alive(field.scene_tet(t))) {
        continue;
      }
      for (const Index near : field.tets()[t]) {
        if (!(nearness[near] > 0) || is_wet(near)) {
          continue;
        }
        for (const Index far : field.tets()[t]) {
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
  for (Index v = 0; v < vertex_count; ++v) {
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

HeatState Cautery::state(const Solver& solver, std::size_t i, Index tet) const {
  const HeatField& field = fields_[i];
  if (!solver.is_tet_alive(field.scene_tet(tet))) {
    return HeatState::vaporised;
  }
  double water = 0;
  for (const Index v : field.tets()[tet]) {
    water += field.water()[v] / 4;
  }
  return heat_state(RemovalRule::water, field.boiling_vertices(tet), water, options_.dry_water);
}

void Cautery::collect_changes(const Solver& solver, std::size_t i, TopologyEdit& edit) const {
  const HeatField& field = fields_[i];
  const Body& body = bodies_[i];
  std::vector<Index> shrinking;
  for (Index t = 0; t < static_cast<Index>(field.tets().size()); ++t) {
    const Index scene_tet = field.scene_tet(t);
    if (!solver.is_tet_alive(scene_tet)) {
      continue;
    }
    const HeatState now = state(solver, i, t);
    if (now == HeatState::vaporised) {
      edit.remove_tets.push_back(scene_tet);
      continue;
    }
    if (now != HeatState::burning) {
      continue;
    }
    std::array<double, 4> water;
    std::array<bool, 4> boiling;
    for (int k = 0; k < 4; ++k) {
      const Index v = field.tets()[t][k];
      water[k] = field.water()[v];
      boiling[k] = field.has_boiled(v);
    }
    const bool is_neo_hookean = body.material.model == ElasticModel::neo_hookean;
    if (is_neo_hookean || body.material.has_volume_constraints) {
      const double factor = shrunk((water[0] + water[1] + water[2] + water[3]) / 4);
      const float volume = rest_volumes_[i][t] * static_cast<float>(factor * factor * factor);
      if (volume < (1 - kLeastChange) * solver.rest_volume(scene_tet)) {
        edit.rest_volumes.push_back({scene_tet, volume});
      }
    }
    for (std::size_t e = 0; e < kTetEdges.size() && !is_neo_hookean; ++e) {
      if (boiling[kTetEdges[e][0]] && boiling[kTetEdges[e][1]]) {
        shrinking.push_back(solver.tet_edges(scene_tet)[e]);
      }
    }
  }
  std::sort(shrinking.begin(), shrinking.end());
  shrinking.erase(std::unique(shrinking.begin(), shrinking.end()), shrinking.end());
  for (const Index e : shrinking) {
    const auto [a, b] = solver.edges()[e];
    const double water =
        (field.water()[field.find_vertex(a)] + field.water()[field.find_vertex(b)]) / 2;
    const float length = rest_lengths_[e] * static_cast<float>(shrunk(water));
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
  followed_.check(solver, "a cautery");
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  CauteryReport report;
  std::vector<std::vector<Share>> touched(fields_.size());
  std::vector<Share> links;
  double weight = 0;
  if (power > 0) {
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      touched[i] = find_touched_vertices(solver, positions, i, tip);
      report.contact_vertices += static_cast<Index>(touched[i].size());
      for (const Share& share : touched[i]) {
        weight += share.weight;
      }
    }
    links = find_touched_links(solver, positions, tip);
    report.contact_links = static_cast<Index>(links.size());
    for (const Share& share : links) {
      weight += share.weight;
    }
  }

  TopologyEdit edit;
  const double energy_before = energy_in();
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    std::vector<HeatSource> sources;
    for (const Share& share : touched[i]) {
      sources.push_back({share.id, power * share.weight / weight});
    }
    fields_[i].step(dt, sources);
    collect_changes(solver, i, edit);
  }
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

void Cautery::validate(const Solver& solver, const TopologyEdit&) const {
  followed_.check(solver, "a cautery");
}

void Cautery::apply(const Solver& solver, const TopologyEdit& edit,
                    const EditResult& result) noexcept {
  followed_.apply(result);
  for (HeatField& field : fields_) {
    field.apply(solver, edit, result);
  }
  follow_sizes(solver);
}

void Cautery::undo(const Solver& solver, const TopologyEdit& edit,
                   const EditResult& result) noexcept {
  followed_.undo();
  for (HeatField& field : fields_) {
    field.undo(solver, edit, result);
  }
  follow_sizes(solver);
}

double Cautery::energy_in() const noexcept {
  double sum = link_energy_spent_;
  for (const HeatField& field : fields_) {
    sum += field.energy_in();
  }
  return sum;
}

HeatLedger Cautery::ledger() const {
  HeatLedger sum;
  for (const HeatField& field : fields_) {
    const HeatLedger ledger = field.ledger();
    sum.in += ledger.in;
    sum.sensible += ledger.sensible;
    sum.latent += ledger.latent;
    sum.removed += ledger.removed;
  }
  return sum;
}

}  // namespace pbdsurg
