// SPDX-License-Identifier: Apache-2.0
#include "thermal/heat_region.h"

#include <algorithm>

#include "pbdsurg/core/error.h"

#include "edit/renumbering.h"

namespace pbdsurg {
namespace {

// Below this, an automatic choice leaves a system to the CPU. A guess, until measured.
constexpr Index kRowsWorthDevice = 1500;

}  // namespace

void HeatRegion::add(const ThermalMesh& mesh, std::span<const Index> seeds, int rings) {
  rows_.resize(static_cast<std::size_t>(mesh.vertex_count()), kInvalidIndex);
  seen_at_.resize(rows_.size());
  ++search_;
  next_front_.clear();
  const auto reach = [&](Index v) {
    if (seen_at_[v] == search_) {
      return;
    }
    seen_at_[v] = search_;
    next_front_.push_back(v);
    if (rows_[v] == kInvalidIndex) {
      rows_[v] = 0;  // the right one comes with update()
      vertices_.push_back(v);
      has_changed_ = true;
    }
  };
  for (const Index v : seeds) {
    reach(v);
  }
  for (int ring = 0; ring < rings; ++ring) {
    std::swap(front_, next_front_);
    next_front_.clear();
    for (const Index v : front_) {
      mesh.for_each_tet(v, [&](Index t) {
        for (const Index corner : mesh.tets()[t]) {
          reach(corner);
        }
      });
    }
  }
}

void HeatRegion::clear() {
  drop_from(0);
}

void HeatRegion::drop_from(Index first_vertex) {
  const auto gone =
      std::partition(vertices_.begin(), vertices_.end(), [&](Index v) { return v < first_vertex; });
  for (auto v = gone; v != vertices_.end(); ++v) {
    rows_[*v] = kInvalidIndex;
  }
  has_changed_ = has_changed_ || gone != vertices_.end();
  vertices_.erase(gone, vertices_.end());
}

void HeatRegion::renumber(const std::vector<Index>& vertices, Index vertex_count) {
  renumber_list(vertices_, vertices);
  std::sort(vertices_.begin(), vertices_.end());
  rows_.assign(static_cast<std::size_t>(vertex_count), kInvalidIndex);
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    rows_[vertices_[i]] = static_cast<Index>(i);
  }
  has_changed_ = true;
}

void HeatRegion::update(const ThermalMesh& mesh, bool needs_surfaces) {
  if (!has_changed_) {
    return;
  }
  has_changed_ = false;
  rows_.resize(static_cast<std::size_t>(mesh.vertex_count()), kInvalidIndex);
  std::sort(vertices_.begin(), vertices_.end());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    rows_[vertices_[i]] = static_cast<Index>(i);
  }
  inner_.assign(vertices_.size(), 1);
  masses_.resize(vertices_.size());
  surfaces_.assign(vertices_.size(), 0);
  tets_.clear();
  conductances_.clear();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Index v = vertices_[i];
    double mass = 0;
    mesh.for_each_tet(v, [&](Index t) {
      const TissueProperties& tissue = mesh.tissues()[mesh.tissue_of_tet(t)];
      mass += tissue.density * mesh.volume(t) / 4;
      const Tet& corners = mesh.tets()[t];
      Tet rows;
      std::transform(corners.begin(), corners.end(), rows.begin(),
                     [&](Index corner) { return rows_[corner]; });
      const Index first = *std::min_element(rows.begin(), rows.end());
      if (first == kInvalidIndex) {
        inner_[i] = 0;
      } else if (first == static_cast<Index>(i)) {
        tets_.push_back(rows);
        conductances_.push_back(mesh.edge_coefficients(t));
        for (double& conductance : conductances_.back()) {
          conductance *= tissue.conductivity;
        }
      }
    });
    masses_[i] = mass;
    surfaces_[i] = needs_surfaces ? mesh.surface_share(v) : 0;
  }
  system_.set_rows(static_cast<Index>(vertices_.size()), tets_);
  system_.set_couplings(conductances_);
  device_.is_old = true;
}

HeatRegion::Solution HeatRegion::solve(std::span<const double> added, std::span<const double> b,
                                       std::span<double> x, const LinearSolveOptions& options) {
  const bool is_worth_it =
      device_.backend == FieldBackend::cuda || system_.row_count() >= kRowsWorthDevice;
  if (device_.system != nullptr && is_worth_it) {
    try {
      if (device_.is_old) {
        device_.takes_rows = device_.system->set_rows(system_.rows(), tets_);
        if (device_.takes_rows) {
          device_.system->set_conductances(conductances_);
        }
        device_.is_old = false;
      }
      if (device_.takes_rows) {
        return {device_.system->solve({.added = added, .b = b, .options = options}, x),
                FieldBackend::cuda};
      }
    } catch (const Error&) {
      device_.is_old = true;
      throw;
    }
  }
  system_.set_added(added);
  return {system_.solve(b, x, options), FieldBackend::cpu};
}

}  // namespace pbdsurg
