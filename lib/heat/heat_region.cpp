// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/heat_region.h"

#include <algorithm>
#include <iterator>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/tissue_state.h"

#include "lib/heat/system_corners.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

// Of an element's edges, W/K.
std::array<double, 6> conductances(const ThermalMesh& mesh, Index element, double temperature) {
  std::array<double, 6> values = mesh.edge_coefficients(element);
  const double conductivity =
      heat_conductivity(mesh.tissues()[mesh.tissue_of_element(element)], temperature);
  for (double& value : values) {
    value *= conductivity;
  }
  return values;
}

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
      mesh.for_each_element(v, [&](Index element) {
        for (const Index corner : mesh.corners(element)) {
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
  mark_changed();
}

void HeatRegion::mark_changed() noexcept {
  has_changed_ = true;
  gone_at_.clear();  // all is laid out anew
}

void HeatRegion::mark_gone(std::span<const Index> vertices) {
  if (has_changed_) {
    return;
  }
  std::copy_if(vertices.begin(), vertices.end(), std::back_inserter(gone_at_),
               [&](Index v) { return row(v) != kInvalidIndex; });
}

void HeatRegion::update(const ThermalMesh& mesh, bool needs_surfaces) {
  if (has_changed_) {
    lay_out(mesh, needs_surfaces);
  } else if (!gone_at_.empty()) {
    drop_gone(mesh, needs_surfaces);
  }
  has_changed_ = false;
  gone_at_.clear();
}

// Calls on_element(element, rows) for each live element of the region of which a row is the
// smallest.
template <class OnElement>
void HeatRegion::measure(const ThermalMesh& mesh, Index row, bool needs_surfaces,
                         const OnElement& on_element) {
  double mass = 0;
  bool is_inner = true;
  mesh.for_each_element(vertices_[row], [&](Index element) {
    mass += mesh.tissues()[mesh.tissue_of_element(element)].density * mesh.volume(element) /
            corner_count(element);
    const Tet rows = system_corners(mesh, element, rows_);
    const Index first = *std::min_element(rows.begin(), rows.end());
    is_inner = is_inner && first != kInvalidIndex;
    if (first == row) {
      on_element(element, rows);
    }
  });
  inner_[row] = is_inner ? 1 : 0;
  masses_[row] = mass;
  surfaces_[row] = needs_surfaces ? mesh.surface_share(vertices_[row]) : 0;
}

void HeatRegion::lay_out(const ThermalMesh& mesh, bool needs_surfaces) {
  rows_.resize(static_cast<std::size_t>(mesh.vertex_count()), kInvalidIndex);
  std::sort(vertices_.begin(), vertices_.end());
  const auto count = static_cast<Index>(vertices_.size());
  for (Index row = 0; row < count; ++row) {
    rows_[vertices_[row]] = row;
  }
  inner_.resize(vertices_.size());
  masses_.resize(vertices_.size());
  surfaces_.resize(vertices_.size());
  element_starts_.assign(1, 0);
  elements_.clear();
  corners_.clear();
  conductances_.clear();
  for (Index row = 0; row < count; ++row) {
    measure(mesh, row, needs_surfaces, [&](Index element, const Tet& rows) {
      elements_.push_back(element);
      corners_.push_back(rows);
      conductances_.push_back(conductances(mesh, element, kBodyTemperature));
    });
    element_starts_.push_back(static_cast<Index>(elements_.size()));
  }
  has_triangles_ = std::ranges::any_of(elements_, is_triangle);
  system_.set_rows(count, corners_);
  system_.set_couplings(conductances_);
  device_.has_old_rows = true;
}

// They keep their places, and conduct nothing.
void HeatRegion::drop_gone(const ThermalMesh& mesh, bool needs_surfaces) {
  gone_rows_.clear();
  std::ranges::sort(gone_at_);
  gone_at_.erase(std::unique(gone_at_.begin(), gone_at_.end()), gone_at_.end());
  for (const Index v : gone_at_) {
    const Index row = rows_[v];
    gone_rows_.push_back(row);
    measure(mesh, row, needs_surfaces, [](Index, const Tet&) {});
    for (Index i = element_starts_[row]; i < element_starts_[row + 1]; ++i) {
      if (!mesh.is_alive(elements_[i])) {
        conductances_[i] = {};
      }
    }
  }
  system_.update_couplings(conductances_, gone_rows_);
  device_.has_old_conductances = true;
}

void HeatRegion::set_temperatures(const ThermalMesh& mesh, std::span<const double> temperatures) {
  if (std::ranges::all_of(mesh.tissues(), [](const ThermalProperties& tissue) {
        return tissue.conductivity_rise == 0;
      })) {
    return;
  }
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    if (mesh.is_alive(elements_[i])) {
      double temperature = 0;
      const int corners = corner_count(elements_[i]);
      for (int k = 0; k < corners; ++k) {
        temperature += temperatures[corners_[i][k]] / corners;
      }
      conductances_[i] = conductances(mesh, elements_[i], temperature);
    }
  }
  system_.set_couplings(conductances_);
  device_.has_old_conductances = true;
}

// Returns the device, if it has the system as it is now.
DeviceSystem* HeatRegion::move_to_device() {
  DeviceSystem* const device = has_triangles_ ? nullptr : device_.choice.find(system_.row_count());
  if (device == nullptr) {
    return nullptr;
  }
  if (device_.has_old_rows) {
    device_.takes_rows = device->set_rows(system_.rows(), corners_);
    device_.has_old_rows = false;
    device_.has_old_conductances = true;
  }
  if (device_.takes_rows && device_.has_old_conductances) {
    device->set_conductances(conductances_);
    device_.has_old_conductances = false;
  }
  return device_.takes_rows ? device : nullptr;
}

void HeatRegion::take_device(HeatRegion& other) noexcept {
  device_.choice.swap(other.device_.choice);
  device_.has_old_rows = other.device_.has_old_rows = true;
}

HeatRegion::Solution HeatRegion::solve(std::span<const double> added, std::span<const double> b,
                                       std::span<double> x, const LinearSolveOptions& options) {
  try {
    if (DeviceSystem* const device = move_to_device()) {
      return {device->solve({.added = added, .b = b, .options = options}, x), true};
    }
  } catch (...) {
    device_.has_old_rows = true;
    throw;
  }
  system_.set_added(added);
  return {system_.solve(b, x, options), false};
}

}  // namespace pbdsurg
