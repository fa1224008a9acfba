// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/heat_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {
namespace {

void check_positive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(what) + " is " + std::to_string(value) +
                          "; it must be positive and finite");
  }
}

// Conductance of the six edges of a tetrahedron: -k V grad N_i . grad N_j, W/K.
std::array<double, 6> edge_conductances(std::span<const Eigen::Vector3d> x, const Tet& tet,
                                        double conductivity) {
  const double volume = tet_volume(x, tet);
  std::array<Eigen::Vector3d, 4> gradients;
  for (int i = 0; i < 4; ++i) {
    const auto& [a, b, c] = kTetTriangles[i];
    // inward area vector of the opposite face over three volumes
    gradients[i] = (x[tet[c]] - x[tet[a]]).cross(x[tet[b]] - x[tet[a]]) / (6 * volume);
  }
  std::array<double, 6> result;
  for (std::size_t e = 0; e < 6; ++e) {
    result[e] = -conductivity * volume * gradients[kTetEdges[e][0]].dot(gradients[kTetEdges[e][1]]);
  }
  return result;
}

}  // namespace

HeatField::HeatField(const TetMesh& mesh, const TissueProperties& tissue, Index first_tet)
    : tissue_(tissue),
      first_tet_(first_tet),
      tets_(mesh.tets().begin(), mesh.tets().end()),
      edges_(find_edges(tets_)),
      tet_edges_(find_tet_edges(tets_, edges_)),
      tet_conductances_(tets_.size()),
      tet_masses_(tets_.size()),
      alive_(tets_.size(), true),
      vertex_tets_(mesh.positions().size(), 0),
      conductances_(edges_.size()),
      limited_(edges_.size()),
      capacities_(mesh.positions().size(), 0.0),
      temperatures_(mesh.positions().size(), kBodyTemperature),
      peaks_(temperatures_),
      water_(mesh.positions().size(), 1.0),
      flows_(mesh.positions().size()) {
  check_positive("tissue density", tissue.density);
  check_positive("tissue specific heat", tissue.specific_heat);
  check_positive("tissue conductivity", tissue.conductivity);
  if (!(tissue.water_fraction >= 0) || !(tissue.water_fraction <= 1)) {
    throw InvalidArgument("tissue water fraction is " + std::to_string(tissue.water_fraction) +
                          "; it must be in [0, 1]");
  }
  edge_tets_.offsets.assign(edges_.size() + 1, 0);
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    tet_masses_[t] = tissue.density * tet_volume(mesh.positions(), tets_[t]);
    tet_conductances_[t] = edge_conductances(mesh.positions(), tets_[t], tissue.conductivity);
    for (const Index edge : tet_edges_[t]) {
      ++edge_tets_.offsets[edge + 1];
    }
    for (const Index v : tets_[t]) {
      capacities_[v] += tet_masses_[t] * tissue.specific_heat / 4;
      ++vertex_tets_[v];
    }
  }
  std::partial_sum(edge_tets_.offsets.begin(), edge_tets_.offsets.end(),
                   edge_tets_.offsets.begin());
  edge_tets_.entries.resize(6 * tets_.size());
  std::vector<Index> next(edge_tets_.offsets.begin(), edge_tets_.offsets.end() - 1);
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    for (const Index edge : tet_edges_[t]) {
      edge_tets_.entries[next[edge]++] = static_cast<Index>(t);
    }
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    sum_edge(static_cast<Index>(e));
  }
}

// Summed afresh from the live tetrahedra: subtracting would drift, and an edge without tissue must
// conduct exactly nothing.
void HeatField::sum_edge(Index edge) noexcept {
  double sum = 0;
  for (const Index t : edge_tets_[edge]) {
    if (alive_[t]) {
      const auto& own = tet_edges_[t];
      sum += tet_conductances_[t][std::find(own.begin(), own.end(), edge) - own.begin()];
    }
  }
  conductances_[edge] = std::max(sum, 0.0);
}

// With k_ij >= 0, explicit Euler keeps T_i between its neighbours' when dt sum_j k_ij <= M_i.
void HeatField::bound_step(double dt) {
  if (dt == bounded_dt_) {
    return;
  }
  std::vector<double> sums(capacities_.size(), 0.0);
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    for (const Index v : edges_[e]) {
      sums[v] += conductances_[e];
    }
  }
  double needed = 1;
  for (std::size_t v = 0; v < sums.size(); ++v) {
    if (capacities_[v] > 0) {
      needed = std::max(needed, dt * sums[v] / capacities_[v]);
    }
  }
  substeps_ = static_cast<int>(std::ceil(std::min<double>(needed, kMostSubsteps)));
  const double h = dt / substeps_;
  limited_edge_count_ = 0;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    double share = 1;
    for (const Index v : edges_[e]) {
      if (h * sums[v] > capacities_[v]) {
        share = std::min(share, capacities_[v] / (h * sums[v]));
      }
    }
    limited_[e] = share * conductances_[e];
    limited_edge_count_ += share < 1;
  }
  bounded_dt_ = dt;
}

// Heat beyond the boiling point turns water to steam before it raises the temperature.
void HeatField::boil(Index vertex) {
  const double excess = temperatures_[vertex] - kBoilingTemperature;
  if (!(excess > 0) || !(water_[vertex] > 0) || !(tissue_.water_fraction > 0)) {
    return;
  }
  const double whole = latent_rise();
  if (excess < water_[vertex] * whole) {
    water_[vertex] -= excess / whole;
    temperatures_[vertex] = kBoilingTemperature;
  } else {
    temperatures_[vertex] -= water_[vertex] * whole;
    water_[vertex] = 0;
  }
}

void HeatField::step(double dt, std::span<const HeatSource> sources) {
  check_positive("dt", dt);
  for (const HeatSource& source : sources) {
    if (source.vertex < 0 || source.vertex >= static_cast<Index>(temperatures_.size())) {
      throw InvalidArgument("heat source at vertex " + std::to_string(source.vertex) +
                            "; ids must be in [0, " + std::to_string(temperatures_.size()) + ")");
    }
    if (!(source.power >= 0) || !std::isfinite(source.power)) {
      throw InvalidArgument("heat source at vertex " + std::to_string(source.vertex) +
                            " has a power of " + std::to_string(source.power) +
                            " W; it must be >= 0 and finite");
    }
  }
  bound_step(dt);
  const double h = dt / substeps_;
  for (int substep = 0; substep < substeps_; ++substep) {
    std::fill(flows_.begin(), flows_.end(), 0.0);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const auto [a, b] = edges_[e];
      const double flow = limited_[e] * (temperatures_[b] - temperatures_[a]);
      flows_[a] += flow;
      flows_[b] -= flow;
    }
    for (const HeatSource& source : sources) {
      if (has_tissue(source.vertex)) {
        flows_[source.vertex] += source.power;
        ledger_.in += h * source.power;
      }
    }
    for (std::size_t v = 0; v < flows_.size(); ++v) {
      if (capacities_[v] > 0) {
        temperatures_[v] += h * flows_[v] / capacities_[v];
        boil(static_cast<Index>(v));
        peaks_[v] = std::max(peaks_[v], temperatures_[v]);
      }
    }
  }
  update_held();
}

// How much warmer the heat that boils all water would make the tissue, K: latent and sensible heat
// scale with the same mass.
double HeatField::latent_rise() const noexcept {
  return tissue_.water_fraction * kLatentHeatOfWater / tissue_.specific_heat;
}

void HeatField::update_held() noexcept {
  ledger_.sensible = ledger_.latent = 0;
  for (std::size_t v = 0; v < capacities_.size(); ++v) {
    ledger_.sensible += capacities_[v] * (temperatures_[v] - kBodyTemperature);
    ledger_.latent += capacities_[v] * (1 - water_[v]) * latent_rise();
  }
}

int HeatField::boiling_vertices(Index tet) const {
  return static_cast<int>(
      std::count_if(tets_[tet].begin(), tets_[tet].end(), [&](Index v) { return has_boiled(v); }));
}

void HeatField::remove_tet(Index tet) noexcept {
  alive_[tet] = false;
  const double share = tet_masses_[tet] * tissue_.specific_heat / 4;
  for (const Index v : tets_[tet]) {
    ledger_.removed +=
        share * (temperatures_[v] - kBodyTemperature + (1 - water_[v]) * latent_rise());
    capacities_[v] -= share;
    if (--vertex_tets_[v] == 0) {
      capacities_[v] = 0;  // exactly nothing, whatever rounding left
    }
  }
}

void HeatField::validate(const Solver&, const TopologyEdit&) const {}

void HeatField::undo(const Solver&, const TopologyEdit&, const EditResult&) noexcept {
  std::terminate();  // under construction on this branch
}

void HeatField::apply(const Solver&, const TopologyEdit&, const EditResult& result) noexcept {
  const auto is_own = [&](Index t) {
    return t >= first_tet_ && t < first_tet_ + static_cast<Index>(tets_.size());
  };
  for (const Index t : result.tets) {
    if (is_own(t)) {
      remove_tet(t - first_tet_);
      bounded_dt_ = 0;
    }
  }
  for (const Index t : result.tets) {
    if (is_own(t)) {
      for (const Index edge : tet_edges_[t - first_tet_]) {
        sum_edge(edge);
      }
    }
  }
  update_held();
}

}  // namespace pbdsurg
