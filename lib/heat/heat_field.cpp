// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/heat_field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/heat/heat_region.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

const HeatOptions& checked(const HeatOptions& options) {
  check_not_negative("active_rise", options.active_rise);
  check(options.tolerance > 0 && options.tolerance < 1, "tolerance", options.tolerance,
        "in (0, 1)");
  check_range("most_iterations", options.most_iterations, 1, 1e6);
  check_not_negative("device_rows", options.device_rows);
  return options;
}

[[noreturn]] void refuse_power(const char* what, Index id, double power) {
  throw InvalidArgument(std::string(what) + " " + std::to_string(id) + " has a power of " +
                        std::to_string(power) + " W; it must be >= 0 and finite");
}

void check_power(const char* what, Index id, double power) {
  if (!(power >= 0) || !std::isfinite(power)) {
    refuse_power(what, id, power);
  }
}

void check_size(const char* what, std::size_t size, std::size_t vertex_count) {
  if (size != vertex_count) {
    throw InvalidArgument(std::string("the snapshot has ") + std::to_string(size) + " values of " +
                          what + "; the field has " + std::to_string(vertex_count) + " vertices");
  }
}

void check_values(const char* what, std::span<const double> values, double low, double high) {
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (!std::isfinite(values[v]) || values[v] < low || values[v] > high) {
      throw InvalidArgument(std::string(what) + " of vertex " + std::to_string(v) +
                            " in the snapshot is " + describe(values[v]) +
                            (std::isinf(high) ? "; it must be finite" : "; it must be in [0, 1]"));
    }
  }
}

// @param among  what lists them
void check_vertices(const char* among, std::span<const Index> vertices, std::size_t vertex_count) {
  std::vector<bool> is_listed(vertex_count);
  for (const Index v : vertices) {
    check_id("vertex", v, vertex_count);
    if (is_listed[v]) {
      throw InvalidArgument("vertex " + std::to_string(v) + " is twice among " + among);
    }
    is_listed[v] = true;
  }
}

}  // namespace

HeatField::RegionPointer::RegionPointer(const HeatOptions& options)
    : region_(std::make_unique<HeatRegion>(options.executor, options.device_rows)) {}
HeatField::RegionPointer::RegionPointer(const RegionPointer& other) {
  other.check();
  region_ = std::make_unique<HeatRegion>(*other.region_);
}
HeatField::RegionPointer::RegionPointer(RegionPointer&&) noexcept = default;
HeatField::RegionPointer& HeatField::RegionPointer::operator=(RegionPointer other) noexcept {
  region_.swap(other.region_);
  return *this;
}
HeatField::RegionPointer::~RegionPointer() = default;

void HeatField::RegionPointer::check() const {
  if (region_ == nullptr) {
    throw_moved_from("a heat field");
  }
}

HeatField::HeatField(const TetMesh& mesh, const ThermalProperties& tissue,
                     const ThermalModel& model, const HeatOptions& options)
    : HeatField(ThermalMesh(mesh, tissue), model, options) {}

HeatField::HeatField(const Tissue& tissue, std::span<const ThermalBody> bodies,
                     const ThermalModel& model, const HeatOptions& options)
    : HeatField(ThermalMesh(tissue, bodies), model, options) {}

HeatField::HeatField(ThermalMesh mesh, const ThermalModel& model, const HeatOptions& options)
    : mesh_(std::move(mesh)), model_(model), options_(checked(options)), region_(options_) {
  check_model(model);
  mesh_.check_current("a thermal mesh");
  seen_growth_ = mesh_.growth();
  seen_version_ = mesh_.version();
  if (model.tissue) {
    mesh_.set_tissue(*model.tissue);
  }
  resize(static_cast<std::size_t>(mesh_.vertex_count()));
  if (options_.active_rise == 0 || has_other_ambient()) {
    pending_.resize(temperatures_.size());
    std::iota(pending_.begin(), pending_.end(), 0);
  }
  if (!mesh_.is_by_itself()) {
    mesh_.tissue().add_follower(mesh_, FollowerRank::heat);  // which may be a copy
    mesh_.tissue().add_follower(*this, FollowerRank::heat);
  }
}

void HeatField::resize(std::size_t vertex_count) {
  temperatures_.resize(vertex_count, kBodyTemperature);
  peaks_.resize(vertex_count, kBodyTemperature);
  for (std::vector<double>* share : {&water_, &survival_, &collagen_}) {
    share->resize(vertex_count, 1.0);
  }
  charred_.resize(vertex_count, 0.0);
}

double HeatField::capacity(Index vertex) const {
  check_id("vertex", vertex, temperatures_.size());
  const double mass = mesh_.mass(vertex);
  return mass > 0 ? mass * specific_heat(tissue(vertex), water_[vertex]) : 0;
}

bool HeatField::has_boiled(Index vertex) const {
  check_id("vertex", vertex, peaks_.size());
  return is_boiled(vertex);
}

int HeatField::boiled_vertices(Index tet) const {
  check_id("tet", tet, mesh_.tets().size());
  const Tet& corners = mesh_.tets()[tet];
  return static_cast<int>(
      std::count_if(corners.begin(), corners.end(), [&](Index v) { return is_boiled(v); }));
}

std::span<const Index> HeatField::active_vertices() const {
  region_.check();
  return region_->vertices();
}

// Above body temperature, and what its steam took, J/kg.
HeatField::Heat HeatField::heat_per_mass(Index vertex) const {
  const ThermalProperties& here = tissue(vertex);
  const double specific = specific_heat(here, water_[vertex]);
  return {specific * (temperatures_[vertex] - kBodyTemperature),
          (1 - water_[vertex]) * here.water_fraction * kLatentHeatOfWater +
              (specific_heat(here, 1.0) - specific) * (kBoilingTemperature - kBodyTemperature)};
}

HeatField::Heat HeatField::heat_of(Index element) const {
  Heat sum;
  const double mass = mesh_.tissues()[mesh_.tissue_of_element(element)].density *
                      mesh_.volume(element) / corner_count(element);
  for (const Index v : mesh_.corners(element)) {
    const Heat heat = heat_per_mass(v);
    sum.sensible += mass * heat.sensible;
    sum.latent += mass * heat.latent;
  }
  return sum;
}

HeatField::Heat HeatField::heat_of(std::span<const Index> vertices) const {
  Heat sum;
  for (const Index v : vertices) {
    const Heat heat = heat_per_mass(v);
    const double mass = mesh_.mass(v);
    sum.sensible += mass * heat.sensible;
    sum.latent += mass * heat.latent;
  }
  return sum;
}

void HeatField::set_temperatures(std::span<const Index> vertices,
                                 std::span<const double> temperatures) {
  mesh_.check_current("a heat field");
  if (vertices.size() != temperatures.size()) {
    throw InvalidArgument("there are " + std::to_string(vertices.size()) + " vertices and " +
                          std::to_string(temperatures.size()) + " temperatures; one each");
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    check_id("vertex", vertices[i], temperatures_.size());
    if (!mesh_.has_tissue(vertices[i])) {
      throw InvalidArgument("temperature of vertex " + std::to_string(vertices[i]) +
                            ", which has no tissue");
    }
    if (!std::isfinite(temperatures[i])) {
      throw InvalidArgument("temperature of vertex " + std::to_string(vertices[i]) + " is " +
                            std::to_string(temperatures[i]) + "; it must be finite");
    }
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Index v = vertices[i];
    const double heat = capacity(v) * (temperatures[i] - temperatures_[v]);
    ledger_.in += heat;
    ledger_.sensible += heat;
    temperatures_[v] = temperatures[i];
    peaks_[v] = std::max(peaks_[v], temperatures[i]);
    pending_.push_back(v);
  }
  has_stepped_ = true;
}

void HeatField::hold(std::span<const Index> vertices) {
  check_vertices("those to hold", vertices, temperatures_.size());
  held_.assign(vertices.begin(), vertices.end());
}

HeatSnapshot HeatField::snapshot() const {
  const std::span<const Index> active = active_vertices();
  HeatSnapshot snapshot{temperatures_, peaks_,     water_,  survival_,
                        collagen_,     charred_,   held_,   {active.begin(), active.end()},
                        pending_,      most_warm_, ledger_, mesh_.tissue().identified_version()};
  std::ranges::sort(snapshot.active);
  std::ranges::sort(snapshot.pending);
  snapshot.pending.erase(std::unique(snapshot.pending.begin(), snapshot.pending.end()),
                         snapshot.pending.end());
  return snapshot;
}

void HeatField::restore(const HeatSnapshot& snapshot) {
  region_.check();
  mesh_.check_current("a heat field");
  const TissueVersion now = mesh_.tissue().identified_version();
  if (snapshot.tissue.tissue != now.tissue) {
    throw InvalidArgument("the snapshot is of another tissue");
  }
  if (snapshot.tissue.number != now.number) {
    throw InvalidArgument("the snapshot is of topology version " +
                          std::to_string(snapshot.tissue.number) + ", the heat field is at " +
                          std::to_string(now.number));
  }
  const std::size_t count = temperatures_.size();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto check_array = [&](const char* what, const std::vector<double>& values, double low,
                               double high) {
    check_size(what, values.size(), count);
    check_values(what, values, low, high);
  };
  check_array("temperature", snapshot.temperatures, -kInfinity, kInfinity);
  check_array("peak temperature", snapshot.peak_temperatures, -kInfinity, kInfinity);
  check_array("water", snapshot.water, 0, 1);
  check_array("survival", snapshot.survival, 0, 1);
  check_array("collagen", snapshot.collagen, 0, 1);
  check_array("char", snapshot.charred, 0, 1);
  check_vertices("the held ones of the snapshot", snapshot.held, count);
  check_vertices("the active ones of the snapshot", snapshot.active, count);
  check_vertices("the pending ones of the snapshot", snapshot.pending, count);
  for (const Index v : snapshot.active) {
    if (mesh_.tissue_of_vertex(v) == kInvalidIndex) {
      throw InvalidArgument("vertex " + std::to_string(v) +
                            " is among the active ones of the snapshot; no tissue of the field "
                            "is or was at it");
    }
  }
  HeatSnapshot taken = snapshot;
  RegionPointer region(options_);
  region->add(mesh_, taken.active, 0);
  region->update(mesh_, model_.surface_transfer > 0);
  // nothing is left to fail
  region->take_device(*region_);
  region_ = std::move(region);
  temperatures_ = std::move(taken.temperatures);
  peaks_ = std::move(taken.peak_temperatures);
  water_ = std::move(taken.water);
  survival_ = std::move(taken.survival);
  collagen_ = std::move(taken.collagen);
  charred_ = std::move(taken.charred);
  held_ = std::move(taken.held);
  pending_ = std::move(taken.pending);
  most_warm_ = taken.most_warm;
  ledger_ = taken.ledger;
  has_stepped_ = true;
}

void HeatField::check(double dt, std::span<const HeatSource> sources,
                      std::span<const TetHeatSource> tet_sources) const {
  region_.check();
  mesh_.check_current("a heat field");
  if (!(dt > 0) || !std::isfinite(dt)) {
    throw InvalidArgument("dt is " + std::to_string(dt) + " s; it must be positive and finite");
  }
  for (const HeatSource& source : sources) {
    check_id("vertex", source.vertex, temperatures_.size());
    check_power("heat source at vertex", source.vertex, source.power);
  }
  for (const TetHeatSource& source : tet_sources) {
    check_id("tet", source.tet, mesh_.tets().size());
    check_power("heat source at tet", source.tet, source.power);
  }
}

// Enthalpy rather than temperature is what lies between: it is linear in the heat that tetrahedra
// hold, where capacity and temperature both vary.
void HeatField::add_vertex(Index vertex, const NewVertex& added) {
  const auto between = [&](std::vector<double>& values) {
    values[vertex] = std::lerp(values[added.first], values[added.second],
                               static_cast<double>(added.share));  // never beyond either
  };
  const double second_share = added.share * specific_heat(tissue(vertex), water_[added.second]);
  const double first_share =
      (1 - static_cast<double>(added.share)) * specific_heat(tissue(vertex), water_[added.first]);
  for (std::vector<double>* values : {&peaks_, &water_, &survival_, &collagen_, &charred_}) {
    between(*values);
  }
  temperatures_[vertex] = std::lerp(temperatures_[added.first], temperatures_[added.second],
                                    second_share / (first_share + second_share));
}

void HeatField::renumber(const Tissue&, const Renumbering& ids) noexcept {
  const auto count = static_cast<std::size_t>(mesh_.vertex_count());
  for (std::vector<double>* values :
       {&temperatures_, &peaks_, &water_, &survival_, &collagen_, &charred_}) {
    renumber_values(*values, ids.vertices, count);
  }
  renumber_list(held_, ids.vertices);
  renumber_list(pending_, ids.vertices);
  region_->renumber(ids.vertices, mesh_.vertex_count());
  seen_growth_ = mesh_.growth();
  seen_version_ = mesh_.version();
}

// A copy that was registered by hand has a mesh that was not.
void HeatField::validate(const Tissue& tissue, const TopologyEdit&) const {
  tissue.check_follower(mesh_, "the mesh of a heat field");
}

void HeatField::follow(const Tissue&, const TissueChange& change) noexcept {
  vertices_before_ = temperatures_.size();
  ledger_before_ = ledger_;
  pending_before_ = pending_.size();
  has_stepped_ = false;
  // the heat of parents stays with their children
  const auto asked = static_cast<std::size_t>(change.first_removed_parent);
  const auto remove = [&](Index element) {
    if (mesh_.tissue_of_element(element) != kInvalidIndex) {
      const Heat gone = heat_of(element);
      ledger_.sensible -= gone.sensible;
      ledger_.latent -= gone.latent;
      ledger_.removed += gone.sensible + gone.latent;
    }
  };
  std::ranges::for_each(std::span(change.removed_tets).first(asked), remove);
  for (const Index triangle : change.removed_triangles) {
    remove(element_of_triangle(triangle));
  }
  resize(static_cast<std::size_t>(mesh_.vertex_count()));
  for (std::size_t i = 0; i < change.edit.new_vertices.size(); ++i) {
    const Index v = change.first_new_vertex + static_cast<Index>(i);
    if (mesh_.tissue_of_vertex(v) != kInvalidIndex) {
      add_vertex(v, change.edit.new_vertices[i]);
    }
  }
  pending_.insert(pending_.end(), mesh_.touched().begin(), mesh_.touched().end());
  if (mesh_.growth() != seen_growth_) {
    region_->mark_changed();
  } else {
    region_->mark_gone(mesh_.touched());
  }
  seen_growth_ = mesh_.growth();
  seen_version_ = mesh_.version();
}

void HeatField::validate_undo(const Tissue&, const TissueChange&) const {
  touched_heat_ = has_stepped_ ? heat_of(mesh_.touched()) : Heat{};
}

void HeatField::undo(const Tissue&, const TissueChange&) noexcept {
  if (has_stepped_) {
    const Heat after = heat_of(mesh_.touched());
    const double sensible = after.sensible - touched_heat_.sensible;
    const double latent = after.latent - touched_heat_.latent;
    ledger_.sensible += sensible;
    ledger_.latent += latent;
    ledger_.removed -= sensible + after.latent - touched_heat_.latent;
  } else {
    ledger_ = ledger_before_;
  }
  resize(vertices_before_);
  if (has_stepped_) {
    const auto is_gone = [&](Index v) { return v >= mesh_.vertex_count(); };
    std::erase_if(pending_, is_gone);
    pending_.insert(pending_.end(), mesh_.touched().begin(), mesh_.touched().end());
    region_->drop_from(mesh_.vertex_count());
  } else {
    pending_.resize(pending_before_);
  }
  std::erase_if(held_, [&](Index v) { return v >= mesh_.vertex_count(); });
  if (mesh_.version() != seen_version_) {
    region_->mark_changed();
  }
  seen_growth_ = mesh_.growth();
  seen_version_ = mesh_.version();
}

}  // namespace pbdsurg
