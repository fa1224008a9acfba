// SPDX-License-Identifier: Apache-2.0
// One step of a heat field; all else of it is in heat_field.cpp.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/tissue_state.h"

#include "lib/heat/heat_region.h"

namespace pbdsurg {
namespace {

// Rings around what is warm when the region grows, so that it need not grow in every step, and how
// many times as warm as HeatOptions::active_rise its rim may become within one.
constexpr int kRings = 3;
constexpr double kRimRise = 10;

// The region is laid out anew when this share of its warm vertices is left.
constexpr double kShrinkAt = 0.5;

bool is_warm(double temperature, double rise) {
  return rise == 0 || std::abs(temperature - kBodyTemperature) > rise;
}

}  // namespace

bool HeatField::takes_part(Index vertex) const {
  return is_warm(temperatures_[vertex], options_.active_rise) ||
         (has_other_ambient() && mesh_.surface_share(vertex) > 0);
}

// Sees to it that all that is warm or heated is in the region with its neighbours.
void HeatField::activate(std::span<const HeatSource> sources,
                         std::span<const TetHeatSource> tet_sources) {
  seeds_.clear();
  for (const Index v : pending_) {
    if (region_->row(v) == kInvalidIndex && mesh_.has_tissue(v) && takes_part(v)) {
      seeds_.push_back(v);
    }
  }
  pending_.clear();
  const auto heat = [&](Index v) {
    const Index row = region_->row(v);
    if ((row == kInvalidIndex || !region_->is_inner(row)) && mesh_.has_tissue(v)) {
      seeds_.push_back(v);
    }
  };
  region_->update(mesh_, model_.surface_transfer > 0);
  for (const HeatSource& source : sources) {
    if (source.power > 0) {
      heat(source.vertex);
    }
  }
  for (const TetHeatSource& source : tet_sources) {
    if (source.power > 0 && mesh_.is_alive(source.tet)) {
      std::for_each(mesh_.tets()[source.tet].begin(), mesh_.tets()[source.tet].end(), heat);
    }
  }
  const std::span<const Index> vertices = region_->vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!region_->is_inner(static_cast<Index>(i)) && takes_part(vertices[i])) {
      seeds_.push_back(vertices[i]);
    }
  }
  if (!seeds_.empty()) {
    region_->add(mesh_, seeds_, options_.active_rise == 0 ? 0 : kRings);
    region_->update(mesh_, model_.surface_transfer > 0);
  }
}

// The system divided by theta dt, and its right-hand side.
void HeatField::fill_rows(double dt, std::span<const HeatSource> sources,
                          std::span<const TetHeatSource> tet_sources) {
  const std::span<const Index> vertices = region_->vertices();
  const std::size_t count = vertices.size();
  rows_.resize(count);
  for (std::vector<double>* array : {&row_temperatures_, &flows_, &added_, &right_, &increments_}) {
    array->resize(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Index v = vertices[i];
    const auto row = static_cast<Index>(i);
    const ThermalProperties& here = tissue(v);
    const double mass = region_->mass(row);
    row_temperatures_[i] = temperatures_[v];
    rows_[i] = {
        .temperature = temperatures_[v],
        .capacity = mass * specific_heat(here, water_[v]),
        .perfusion =
            model_.has_perfusion ? perfusion_cooling(here, survival_[v]) * mass / here.density : 0,
        .surface = model_.surface_transfer * region_->surface(row),
        .power = 0,
        .is_held = false,
    };
  }
  const auto deliver = [&](Index v, double power) {
    const Index row = region_->row(v);
    if (row != kInvalidIndex && rows_[row].capacity > 0) {
      rows_[row].power += power;
    }
  };
  for (const HeatSource& source : sources) {
    deliver(source.vertex, source.power);
  }
  for (const TetHeatSource& source : tet_sources) {
    for (const Index v : mesh_.tets()[source.tet]) {
      deliver(v, mesh_.is_alive(source.tet) ? source.power / 4 : 0);
    }
  }
  for (const Index v : held_) {
    const Index row = region_->row(v);
    if (row != kInvalidIndex) {
      rows_[row].is_held = true;
      rows_[row].power = rows_[row].perfusion = rows_[row].surface = 0;
    }
  }
  region_->set_temperatures(mesh_, row_temperatures_);
  region_->system().flows(row_temperatures_, flows_);
  for (std::size_t i = 0; i < count; ++i) {
    const Row& row = rows_[i];
    added_[i] = row.is_held ? std::numeric_limits<double>::infinity()
                            : row.capacity / (model_.theta * dt) + row.perfusion + row.surface;
    right_[i] = (flows_[i] + row.power - row.perfusion * (row.temperature - kBodyTemperature) -
                 row.surface * (row.temperature - model_.ambient_temperature)) /
                model_.theta;
    increments_[i] = 0;
  }
}

// Whether the solution has warmed the rim so much that heat would have gone on: the region is then
// larger, and the step has to be made anew.
bool HeatField::grow_rim(int rings) {
  if (options_.active_rise == 0) {
    return false;
  }
  seeds_.clear();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!region_->is_inner(static_cast<Index>(i)) &&
        is_warm(rows_[i].temperature + increments_[i], kRimRise * options_.active_rise)) {
      seeds_.push_back(region_->vertices()[i]);
    }
  }
  if (seeds_.empty()) {
    return false;
  }
  region_->add(mesh_, seeds_, rings);
  region_->update(mesh_, model_.surface_transfer > 0);
  return true;
}

// Heat that held rows give to others, W. @param flows  into each row
double HeatField::held_flow(std::span<const double> flows) const {
  double sum = 0;
  for (const Index v : held_) {
    const Index row = region_->row(v);
    sum -= row == kInvalidIndex ? 0 : flows[row];
  }
  return sum;
}

// What the solver's tolerance left of the heat goes to where heat went, in proportion, so that no
// joule is lost; and the ledger of the step.
void HeatField::balance(double dt) {
  const double theta = model_.theta;
  double delivered = 0, lost = 0, taken = 0, scale = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (!row.is_held) {
      const double own = row.capacity + theta * dt * (row.perfusion + row.surface);
      delivered += row.power;
      lost += row.perfusion * (row.temperature - kBodyTemperature) +
              row.surface * (row.temperature - model_.ambient_temperature);
      taken += own * increments_[i];
      scale += own * std::abs(increments_[i]);
    }
  }
  double held = 0;  // W at the beginning of the step
  if (!held_.empty()) {
    held = held_flow(flows_);
    held_increments_.resize(rows_.size());
    region_->system().flows(increments_, held_increments_);
    taken -= theta * dt * held_flow(held_increments_);
    std::transform(increments_.begin(), increments_.end(), right_.begin(),
                   [](double d) { return std::abs(d); });
    region_->system().flows(right_, held_increments_);
    scale -= theta * dt * held_flow(held_increments_);
  }
  const double left = dt * (delivered + held - lost) - taken;
  const double share = scale > 0 ? left / scale : 0;
  Heat change;
  double surface = 0, perfusion = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    increments_[i] += share * std::abs(increments_[i]);
    const double during = row.temperature + theta * increments_[i];
    change.sensible += row.capacity * increments_[i];
    surface += row.surface * (during - model_.ambient_temperature);
    perfusion += row.perfusion * (during - kBodyTemperature);
  }
  if (!held_.empty()) {
    region_->system().flows(increments_, held_increments_);
    held += theta * held_flow(held_increments_);
  }
  ledger_.in += dt * (delivered + held);
  ledger_.surface += dt * surface;
  ledger_.perfusion += dt * perfusion;
  ledger_.sensible += change.sensible;
}

void HeatField::advance_state(double dt, HeatReport& report) {
  double steam = 0;  // and smoke
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!(rows_[i].capacity > 0)) {
      continue;
    }
    const Index v = region_->vertices()[i];
    const ThermalProperties& here = tissue(v);
    temperatures_[v] += increments_[i];
    if (model_.has_latent_heat && !rows_[i].is_held) {
      const Boiled<double> boiled = boil(here, temperatures_[v], water_[v]);
      const Ablated<double> ablated = ablate(here, boiled.temperature, boiled.water);
      temperatures_[v] = ablated.temperature;
      water_[v] = boiled.water;
      steam += region_->mass(static_cast<Index>(i)) * (boiled.steam_heat + ablated.smoke_heat);
    }
    const double now = temperatures_[v];
    peaks_[v] = std::max(peaks_[v], now);
    if (now > kDamageTemperature) {
      survival_[v] = surviving(here.damage, survival_[v], now, dt);
      collagen_[v] = surviving(kCollagenDenaturation, collagen_[v], now, dt);
      charred_[v] = charring(charred_[v], now, dt);
    }
    report.hottest = std::max(report.hottest, now);
  }
  ledger_.sensible -= steam;
  ledger_.latent += steam;
}

// Lays the region out anew when much of what was warm has cooled: before a step, so that until then
// the region is what the last one worked on.
void HeatField::shrink() {
  if (options_.active_rise == 0) {
    return;
  }
  seeds_.clear();
  for (const Index v : region_->vertices()) {
    if (mesh_.has_tissue(v) && takes_part(v)) {
      seeds_.push_back(v);
    }
  }
  const auto warm = static_cast<Index>(seeds_.size());
  if (warm < kShrinkAt * most_warm_) {
    region_->clear();
    region_->add(mesh_, seeds_, kRings);
    most_warm_ = warm;
  }
  most_warm_ = std::max(most_warm_, warm);
}

HeatReport HeatField::step(double dt, std::span<const HeatSource> sources,
                           std::span<const TetHeatSource> tet_sources) {
  check(dt, sources, tet_sources);
  shrink();
  activate(sources, tet_sources);
  HeatReport report;
  report.slivers = mesh_.sliver_count();
  has_stepped_ = true;
  if (region_->vertices().empty()) {
    return report;
  }
  int rings = kRings;
  do {
    fill_rows(dt, sources, tet_sources);
    const auto [solve, is_on_device] = region_->solve(
        added_, right_, increments_,
        {.tolerance = options_.tolerance, .most_iterations = options_.most_iterations});
    report.is_on_device = is_on_device;
    report.iterations += solve.iterations;
    report.residual = solve.residual;
    report.converged = solve.converged;
    report.accepted =
        std::isfinite(solve.residual) && std::all_of(increments_.begin(), increments_.end(),
                                                     [](double d) { return std::isfinite(d); });
    rings *= 2;
  } while (report.accepted && grow_rim(rings));
  report.active_vertices = static_cast<Index>(region_->vertices().size());
  if (report.accepted) {
    balance(dt);
    advance_state(dt, report);
  }
  return report;
}

}  // namespace pbdsurg
