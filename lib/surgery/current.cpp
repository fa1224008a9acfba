// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/current.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pbdsurg/heat/tissue_state.h"

#include "lib/surgery/element_ids.h"
#include "lib/surgery/element_means.h"
#include "lib/tissue/renumber.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// K from body temperature: conductivity has not changed by more than 1.5 percent where tissue
// warms, and 0.15 percent once it has cooled.
constexpr double kWarm = 1;
constexpr double kCooled = 0.1;

// Around the touched triangle; with edges longer than two radii they hold four fifths of the heat.
constexpr int kDiskRings = 3;

double mean_edge(const ThermalMesh& mesh, const Triangle& triangle) {
  const std::span<const Eigen::Vector3d> x = mesh.rest_positions();
  return ((x[triangle[0]] - x[triangle[1]]).norm() + (x[triangle[1]] - x[triangle[2]]).norm() +
          (x[triangle[2]] - x[triangle[0]]).norm()) /
         3;
}

// m, of a regular tetrahedron of the same volume, or an equilateral triangle of the same area
double edge_of(const ThermalMesh& mesh, Index element) {
  if (!is_triangle(element)) {
    return std::cbrt(6 * std::numbers::sqrt2 * mesh.volume(element));
  }
  const Triangle& triangle = mesh.tissue().triangles()[triangle_of_element(element)];
  return std::sqrt(4 / std::numbers::sqrt3 * triangle_area(mesh.rest_positions(), triangle));
}

}  // namespace

Current::Current(const HeatField& field, const CauteryOptions& options, ScenePositions& positions)
    : radius_(options.contact_radius), potential_(field, options.potential), positions_(positions) {
  follow(field);
}

void Current::follow(const HeatField& field) noexcept {
  const ThermalMesh& mesh = field.mesh();
  const auto first_tet = static_cast<Index>(conductivities_.tets.size());
  const auto first_triangle = static_cast<Index>(conductivities_.triangles.size());
  conductivities_.resize(mesh.tet_count(), mesh.triangle_count());
  find_conductivities(field, first_tet, first_triangle);
  has_updated_ = false;
  seen_elements_.resize(mesh.tet_count(), mesh.triangle_count());
  seen_vertices_.resize(static_cast<std::size_t>(field.mesh().vertex_count()));
}

// Of all from some on.
void Current::find_conductivities(const HeatField& field, Index first_tet, Index first_triangle) {
  for (Index t = first_tet; t < field.mesh().tet_count(); ++t) {
    find_conductivity(field, t);
  }
  for (Index t = first_triangle; t < field.mesh().triangle_count(); ++t) {
    find_conductivity(field, element_of_triangle(t));
  }
}

void Current::restore(const HeatField& field, std::vector<Index> warm) noexcept {
  potential_.forget();
  find_conductivities(field, 0, 0);
  warm_ = std::move(warm);
  bridged_.clear();
  cooled_.clear();
  shares_.clear();
}

void Current::renumber(const HeatField& field, const Renumbering& ids) {
  const ThermalMesh& mesh = field.mesh();
  renumber_elements(conductivities_, ids, mesh);
  renumber_elements(warm_, ids);
  renumber_elements(bridged_, ids);
  seen_elements_.assign(mesh.tet_count(), mesh.triangle_count(), 0);
  seen_vertices_.assign(static_cast<std::size_t>(field.mesh().vertex_count()), 0);
  cooled_.clear();
  shares_.clear();
}

void Current::undo(const HeatField& field) noexcept {
  const ThermalMesh& mesh = field.mesh();
  conductivities_.resize(mesh.tet_count(), mesh.triangle_count());
  seen_elements_.resize(mesh.tet_count(), mesh.triangle_count());
  seen_vertices_.resize(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::vector<Index>* elements : {&warm_, &bridged_}) {  // triangles come with bodies alone
    std::erase_if(*elements, [&](Index e) { return e >= mesh.tet_count(); });
  }
  for (const Index v : mesh.touched()) {
    if (has_updated_) {  // what is back was left out while it was gone
      mesh.for_each_element(v, [&](Index e) { find_conductivity(field, e); });
    }
  }
}

void Current::find_conductivity(const HeatField& field, Index element) {
  const ThermalMesh& mesh = field.mesh();
  if (mesh.tissue_of_element(element) == kInvalidIndex) {
    return;
  }
  const ThermalProperties& tissue = mesh.tissues()[mesh.tissue_of_element(element)];
  if (!field.model().has_variable_conductivity) {
    conductivities_[element] = tissue.electrical_conductivity;
    return;
  }
  conductivities_[element] =
      electrical_conductivity(tissue, mean_temperature(field, element), mean_water(field, element));
}

// Whether that is for the first time in this round.
bool Current::meet(Index element) {
  std::uint32_t& seen = seen_elements_[element];
  const bool is_first = seen != round_;
  seen = round_;
  return is_first;
}

// Sparks pass what is dry of an element, as far as they reach.
void Current::bridge(const HeatField& field) {
  const ThermalMesh& mesh = field.mesh();
  for (const Index e : bridged_) {
    if (mesh.is_alive(e)) {
      const double passed = std::min(1.0, kSparkReach / edge_of(mesh, e));
      conductivities_[e] = electrical_conductivity(mesh.tissues()[mesh.tissue_of_element(e)],
                                                   mean_temperature(field, e),
                                                   std::lerp(mean_water(field, e), 1.0, passed));
    }
  }
}

// Of elements that are warm, or not as wet as they were, and of those that were so until they
// have cooled: from then on they do not change.
void Current::update_conductivities(const HeatField& field) {
  if (!field.model().has_variable_conductivity) {
    return;
  }
  ++round_;
  has_updated_ = true;
  std::swap(warm_before_, warm_);
  warm_.clear();
  for (const Index v : field.active_vertices()) {
    if (field.temperatures()[v] < kBodyTemperature + kWarm && field.water()[v] == 1) {
      continue;
    }
    field.mesh().for_each_element(v, [&](Index e) {
      if (meet(e)) {
        warm_.push_back(e);
        find_conductivity(field, e);
      }
    });
  }
  for (const Index e : warm_before_) {
    if (seen_elements_[e] != round_ && field.mesh().is_alive(e)) {
      find_conductivity(field, e);
      if (mean_temperature(field, e) > kBodyTemperature + kCooled) {
        warm_.push_back(e);
      }
    }
  }
  bridge(field);
}

void Current::touch(const Solver& solver, const HeatField& field, const ElectrodeContact& contact) {
  is_new_ = true;
  for (const Index e : bridged_) {
    find_conductivity(field, e);
  }
  bridged_.clear();
  is_sparking_ = false;
  const NearestPoint& nearest = contact.nearest();
  const bool touches = nearest.gap <= radius_;
  disk_radius_ = std::sqrt(contact.area() / std::numbers::pi);
  // a disk's closed form is that of a half-space, which a sheet is not
  is_disk_ = touches && field.mesh().tissue().triangles_at(nearest.triangle[0]).empty() &&
             mean_edge(field.mesh(), nearest.triangle) > 2 * disk_radius_;
  shares_.clear();
  cooled_.clear();
  if (is_disk_) {
    find_near_tets(field, nearest.triangle);
    positions_.read(solver, near_vertices_);
    const DiskContact disk{nearest.point, -nearest.outward, disk_radius_};
    disk_.distribute(disk, positions_.values(), field.mesh().tets(), near_tets_, shares_);
    vertex_count_ = static_cast<Index>(shares_.size());
    for (const auto& [vertex, share] : shares_) {  // the metal takes it where the current makes it
      cooled_.push_back({vertex, share * contact.area()});
    }
    return;
  }
  contact.collect_patch(radius_, patch_, [](Index) { return true; });
  if (touches && patch_.empty()) {
    // between vertices of a mesh with very long triangles
    patch_.push_back({nearest.triangle[0], 1});
  }
  vertex_count_ = static_cast<Index>(patch_.size());
  for (const PatchVertex& touched : patch_) {
    cooled_.push_back({touched.vertex, touched.weight * contact.area_of(touched.vertex)});
  }
  potential_.set_patch(patch_, contact.area());
}

bool Current::arc(const HeatField& field, const ElectrodeContact& contact) {
  const auto is_wet = [&](Index v) { return field.water()[v] > field.model().dry_water; };
  contact.collect_patch(radius_, patch_, [&](Index v) { return !is_wet(v); });
  if (is_disk_) {
    is_sparking_ = field.model().has_variable_conductivity;
    return is_sparking_;
  }
  // through dry tissue, which may be thinner than the mesh resolves, to the wet tissue behind it
  behind_.clear();
  for (const PatchVertex& dry : patch_) {
    field.mesh().for_each_element(dry.vertex, [&](Index e) {
      for (const Index v : field.mesh().corners(e)) {
        if (is_wet(v)) {
          behind_.push_back({v, dry.weight});
        }
      }
    });
  }
  contact.collect_patch(radius_ + kSparkReach, patch_, is_wet);
  patch_.insert(patch_.end(), behind_.begin(), behind_.end());
  std::sort(patch_.begin(), patch_.end(), [](const PatchVertex& a, const PatchVertex& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.weight > b.weight;
  });
  const auto same = [](const PatchVertex& a, const PatchVertex& b) { return a.vertex == b.vertex; };
  patch_.erase(std::unique(patch_.begin(), patch_.end(), same), patch_.end());
  if (patch_.empty()) {
    return false;
  }
  find_bridged(field);
  potential_.set_patch(patch_, contact.area());
  is_new_ = true;
  return true;
}

// Those at the patch.
void Current::find_bridged(const HeatField& field) {
  if (!field.model().has_variable_conductivity) {
    return;
  }
  ++round_;
  for (const PatchVertex& touched : patch_) {
    field.mesh().for_each_element(touched.vertex, [&](Index e) {
      if (meet(e)) {
        bridged_.push_back(e);
      }
    });
  }
  bridge(field);
}

// Within some rings of a triangle of the surface.
void Current::find_near_tets(const HeatField& field, const Triangle& triangle) {
  ++round_;
  near_tets_.clear();
  near_vertices_.assign(triangle.begin(), triangle.end());
  for (const Index v : triangle) {
    seen_vertices_[v] = round_;
  }
  std::size_t next = 0;
  for (int ring = 0; ring < kDiskRings; ++ring) {
    for (const std::size_t end = near_vertices_.size(); next < end; ++next) {
      field.mesh().for_each_element(near_vertices_[next], [&](Index t) {
        if (!meet(t)) {
          return;
        }
        near_tets_.push_back(t);
        for (const Index v : field.mesh().corners(t)) {
          if (seen_vertices_[v] != round_) {
            seen_vertices_[v] = round_;
            near_vertices_.push_back(v);
          }
        }
      });
    }
  }
  std::sort(near_tets_.begin(), near_tets_.end());
}

TissueLoad Current::find_load(const Solver& solver, const HeatField& field) {
  const TissueLoad load = is_disk_ ? find_disk_load(field) : find_potential_load(solver);
  is_new_ = false;
  return load;
}

// The ways of current as parallel: each takes the heat of the disk times its own conductivity.
TissueLoad Current::find_disk_load(const HeatField& field) {
  const ThermalMesh& mesh = field.mesh();
  TissueLoad load;
  heat_.clear();
  for (const auto& [vertex, share] : shares_) {
    const ThermalProperties& tissue = mesh.tissues()[mesh.tissue_of_vertex(vertex)];
    double water = field.water()[vertex];
    if (is_sparking_ && water > field.model().dry_water) {
      water = 1;  // cells that large have wet tissue behind a dry layer
    }
    const double conductivity =
        field.model().has_variable_conductivity
            ? electrical_conductivity(tissue, field.temperatures()[vertex], water)
            : tissue.electrical_conductivity;
    const double conductance = 4 * disk_radius_ * share * conductivity;
    load.conductance += conductance;
    heat_.push_back({vertex, conductance});
  }
  load.heat = heat_;
  return load;
}

TissueLoad Current::find_potential_load(const Solver& solver) {
  if (is_new_) {
    positions_.read(solver, potential_.find_region(conductivities_));
  }
  const PotentialReport& report = potential_.solve(conductivities_, positions_.values());
  heat_.clear();
  const std::span<const Index> vertices = potential_.vertices();
  const std::span<const double> watts = potential_.vertex_heat();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    heat_.push_back({vertices[i], std::max(0.0, watts[i])});
  }
  TissueLoad load;
  load.conductance = report.conductance;
  load.iterations = report.is_new ? report.iterations : 0;
  load.converged = report.has_converged;
  load.heat = heat_;
  return load;
}

}  // namespace pbdsurg
