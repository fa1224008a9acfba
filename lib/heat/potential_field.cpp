// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/potential_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/base/shared_work.h"
#include "lib/heat/contact_region.h"
#include "lib/heat/device_system.h"
#include "lib/heat/local_system.h"
#include "lib/heat/region_conductances.h"

namespace pbdsurg {
namespace {

constexpr double kHeld = std::numeric_limits<double>::infinity();

// A vertex with the spreading resistance R = r / K_ii of a disk of the vertex's area: r = 1.5 on a
// flat surface of cubes, where K_ii = 3 sigma h and R = 1 / (4 sigma 0.5 h).
constexpr double kVertexResistance = 1.5;

// Weight from which a vertex counts as touched whole: next to 1 the conductance of a part would be
// so large that the residual's tolerance, which is relative, would mean nothing.
constexpr double kWhole = 0.99;

constexpr double kUnknown = -1;  // potential

template <class T>
void check_size(const char* what, std::span<T> values, Index count) {
  if (values.size() != static_cast<std::size_t>(count)) {
    throw InvalidArgument(std::string(what) + " has " + std::to_string(values.size()) +
                          " entries; it must have " + std::to_string(count));
  }
}

// None are needed for sheets that do not conduct.
void check_sizes(const ElementSpan& conductivities, const ThermalMesh& mesh) {
  check_size("conductivities", conductivities.tets, mesh.tet_count());
  if (mesh.has_sheets() || !conductivities.triangles.empty()) {
    check_size("conductivities of triangles", conductivities.triangles, mesh.triangle_count());
  }
}

const PotentialOptions& checked(const PotentialOptions& options) {
  check(options.region_radii > 1 && std::isfinite(options.region_radii), "region_radii",
        options.region_radii, "> 1 and finite");
  check(options.tolerance > 0 && options.tolerance < 1, "tolerance", options.tolerance,
        "in (0, 1)");
  check(options.most_iterations >= 0, "most_iterations", options.most_iterations, ">= 0");
  check(options.conductivity_change >= 0, "conductivity_change", options.conductivity_change,
        ">= 0");
  check_not_negative("device_rows", options.device_rows);
  return options;
}

// S, between the electrode and a vertex that it touches in part, less than kWhole: for what the
// resistance of a disk of that part exceeds that of a disk of all of it.
double film(const PatchVertex& touched, double coupling_sum) {
  const double root = std::sqrt(touched.weight);
  return coupling_sum / kVertexResistance * root / (1 - root);
}

}  // namespace

struct PotentialField::Work final : Follower {
  Work(const ThermalMesh& of, const PotentialOptions& wanted)
      : mesh(of),
        options(wanted),
        system(wanted.executor),
        device(wanted.executor, wanted.device_rows),
        around(of, wanted.region_radii) {}

  // Takes part in edits; one by itself has none.
  void follow_tissue() {
    if (!mesh.is_by_itself()) {
      mesh.tissue().add_follower(*this, FollowerRank::heat);
    }
  }

  // Topology is looked at by solve(); ids are the mesh's.
  void follow(const Tissue&, const TissueChange&) noexcept override {}
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering& ids) noexcept override {
    around.renumber(ids.vertices);
    is_patch_new = true;
    leave_region();
    report = {};
  }

  [[nodiscard]] const PotentialRegion& region() const { return around.region(); }
  void check_positions(std::span<const Eigen::Vector3f> positions) const;
  void enter_region();
  void leave_region();
  void move_to_device();
  bool update_conductances(std::span<const Eigen::Vector3f> positions, bool is_region_new);
  LinearSolveReport solve_system();
  void solve();
  void sum_heat();

  const ThermalMesh& mesh;
  PotentialOptions options;
  LocalSystem system;
  DeviceChoice device;
  DeviceSystem* on_device = nullptr;  // that solves in this region; null: system does
  ContactRegion around;
  RegionConductances conductances;
  bool is_patch_new = true;  // since the last solution

  std::vector<PatchVertex> sorted_patch;                 // scratch
  std::vector<double> added, sources, potentials, heat;  // [row_count]
  std::vector<double> element_heat;                      // [element_count]
  std::vector<double> corner_heat;                       // [element_count] at each, scratch
  std::vector<double> last;                              // [vertex_count] kUnknown, scratch
  std::vector<double> kept;                              // [row_count] scratch
  PotentialReport report;
};

PotentialField::PotentialField(const ThermalMesh& mesh, const PotentialOptions& options)
    : work_(std::make_unique<Work>(mesh, checked(options))) {
  work_->follow_tissue();
}

PotentialField::PotentialField(const HeatField& field, const PotentialOptions& options) {
  PotentialOptions wanted = checked(options);
  wanted.executor = wanted.executor.or_else(field.executor());
  work_ = std::make_unique<Work>(field.mesh(), wanted);
  work_->follow_tissue();
}

PotentialField::~PotentialField() = default;

// Follows the tissue as it did, so that an edit before can still be undone.
void PotentialField::forget() noexcept {
  auto made = std::make_unique<Work>(work_->mesh, work_->options);
  static_cast<Follower&>(*made) = std::move(static_cast<Follower&>(*work_));
  work_ = std::move(made);
}

const PotentialReport& PotentialField::report() const noexcept {
  return work_->report;
}
std::span<const Index> PotentialField::vertices() const noexcept {
  return work_->region().vertices;
}
std::span<const double> PotentialField::potentials() const noexcept {
  return work_->potentials;
}
std::span<const double> PotentialField::vertex_heat() const noexcept {
  return work_->heat;
}
std::span<const Index> PotentialField::elements() const noexcept {
  return work_->region().elements;
}
std::span<const double> PotentialField::element_heat() const noexcept {
  return work_->element_heat;
}

void PotentialField::set_patch(std::span<const PatchVertex> patch, double area) {
  Work& work = *work_;
  if (!patch.empty()) {
    check(area > 0 && std::isfinite(area), "contact area", area, "positive and finite");
  }
  for (const PatchVertex& touched : patch) {
    check_vertex("electrode patch", touched.vertex, work.mesh.vertex_count());
    if (!(touched.weight > 0) || !(touched.weight <= 1)) {
      throw InvalidArgument("electrode patch has a weight of " + std::to_string(touched.weight) +
                            " at vertex " + std::to_string(touched.vertex) +
                            "; it must be in (0, 1]");
    }
  }
  std::vector<PatchVertex>& sorted = work.sorted_patch;
  sorted.assign(patch.begin(), patch.end());
  std::ranges::sort(sorted, {}, &PatchVertex::vertex);
  const auto twice = std::ranges::adjacent_find(sorted, {}, &PatchVertex::vertex);
  if (twice != sorted.end()) {
    throw InvalidArgument("electrode patch has vertex " + std::to_string(twice->vertex) + " twice");
  }
  work.is_patch_new |= work.around.set_patch(sorted, area);
}

void PotentialField::set_ground(std::span<const Index> vertices) {
  for (const Index v : vertices) {
    check_vertex("ground", v, work_->mesh.vertex_count());
  }
  work_->around.set_ground(vertices);
}

std::span<const Index> PotentialField::find_region(const ElementSpan& conductivities) {
  work_->mesh.check_current("the mesh of a potential");
  check_sizes(conductivities, work_->mesh);
  return work_->around.find(conductivities) ? work_->around.found_vertices()
                                            : std::span<const Index>();
}

const PotentialReport& PotentialField::solve(const ElementSpan& conductivities,
                                             std::span<const Eigen::Vector3f> positions) {
  Work& work = *work_;
  work.mesh.check_current("the mesh of a potential");
  check_sizes(conductivities, work.mesh);
  if (!positions.empty()) {
    check_size("positions", positions, work.mesh.vertex_count());
  }
  if (!work.around.find(conductivities)) {
    work.leave_region();
    return work.report;
  }
  work.check_positions(positions);
  try {
    const bool is_region_new = work.around.has_next();
    if (is_region_new) {
      work.enter_region();
    }
    work.report.is_new = work.update_conductances(positions, is_region_new);
    if (work.report.is_new) {
      work.solve();
      work.sum_heat();
    }
  } catch (...) {  // the device failed, or memory ran out
    work.leave_region();
    work.report = {};
    throw;
  }
  return work.report;
}

void PotentialField::Work::check_positions(std::span<const Eigen::Vector3f> positions) const {
  for (const Index v : around.found_vertices()) {
    if (!positions.empty() && !positions[v].allFinite() && mesh.has_tissue(v)) {
      throw InvalidArgument("vertex " + std::to_string(v) + " has a position that is not finite");
    }
  }
}

// Potentials of vertices of both regions go along.
void PotentialField::Work::enter_region() {
  last.resize(static_cast<std::size_t>(mesh.vertex_count()), kUnknown);
  const auto spread = [&](const PotentialRegion& of, auto value) {
    for (std::size_t row = 0; row < of.vertices.size(); ++row) {
      if (of.vertices[row] < mesh.vertex_count()) {  // else an undo took it away
        last[of.vertices[row]] = value(row);
      }
    }
  };
  spread(region(), [&](std::size_t row) { return potentials[row]; });
  const std::span<const Index> vertices = around.found_vertices();
  kept.resize(vertices.size());
  std::ranges::transform(vertices, kept.begin(), [&](Index v) { return last[v]; });
  spread(region(), [](std::size_t) { return kUnknown; });
  potentials.swap(kept);
  around.enter();
  system.set_rows(static_cast<Index>(region().vertices.size()), region().corners);
  system.set_groups(region().group_starts);
  move_to_device();
}

void PotentialField::Work::move_to_device() {
  on_device = region().has_triangles ? nullptr : device.find(system.row_count());
  if (on_device != nullptr && !on_device->set_rows(system.rows(), region().corners)) {
    on_device = nullptr;
  }
}

// The circuit is open, and nothing is left of the last solution.
void PotentialField::Work::leave_region() {
  report = {};
  report.lost_count = around.patch_size();
  around.leave();
  potentials.clear();
  heat.clear();
  element_heat.clear();
}

// Returns whether a new solution is due.
bool PotentialField::Work::update_conductances(std::span<const Eigen::Vector3f> positions,
                                               bool is_region_new) {
  const RegionConductances::Source source{mesh, region(), around.found_conductivities(), positions};
  const RegionConductances::Takers takers{system, on_device};
  if (is_region_new) {
    conductances.set(source, takers);
    return true;
  }
  const double change = options.conductivity_change;
  return conductances.update(source, change, change * around.found_contact().edge, is_patch_new,
                             takers);
}

void PotentialField::Work::solve() {
  const std::size_t rows = region().vertices.size();
  const std::span<const Eigen::Vector3d> points = mesh.rest_positions();
  added.assign(rows, 0.0);
  sources.assign(rows, 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    double& start = potentials[row];
    if (region().is_ground[row] != 0) {
      start = 0;
      added[row] = kHeld;
    } else if (!region().has_ground) {
      start = 1;
    } else if (start == kUnknown) {
      start = around.contact().guess(points[region().vertices[row]]);
    }
  }
  for (const PatchVertex& seed : around.seeds()) {
    const Index row = around.row_of(seed.vertex);
    if (seed.weight >= kWhole) {
      added[row] = kHeld;
      potentials[row] = 1;
    } else {
      added[row] = sources[row] = film(seed, on_device != nullptr ? 1 : system.coupling_sum(row));
    }
  }
  is_patch_new = false;
  element_heat.resize(region().elements.size());
  heat.resize(rows);
  LinearSolveReport solution;
  if (region().has_ground) {
    solution = solve_system();
  }
  report = {.is_closed = region().has_ground,
            .is_new = true,
            .iterations = solution.iterations,
            .residual = solution.residual,
            .has_converged = solution.converged,
            .vertex_count = static_cast<Index>(rows),
            .lost_count = around.patch_size() - static_cast<Index>(around.seeds().size()),
            .is_on_device = on_device != nullptr};
}

// With its heat, on the device.
LinearSolveReport PotentialField::Work::solve_system() {
  const LinearSolveOptions how{options.tolerance, options.most_iterations};
  if (on_device != nullptr) {
    return on_device->solve({conductances.used(), added, sources, true, how, element_heat, heat},
                            potentials);
  }
  system.set_added(added);
  return system.solve(sources, potentials, how);
}

void PotentialField::Work::sum_heat() {
  if (!region().has_ground) {
    std::ranges::fill(element_heat, 0.0);
    std::ranges::fill(heat, 0.0);
    return;
  }
  if (on_device != nullptr) {
    report.conductance = std::accumulate(heat.begin(), heat.end(), 0.0);
    return;
  }
  const std::span<const Tet> corners = region().corners;
  corner_heat.resize(corners.size());
  share_work(options.executor, std::ssize(corners), [&](const Worker& worker) {
    const std::size_t first = corners.size() * worker.thread / worker.count;
    const std::size_t end = corners.size() * (worker.thread + 1) / worker.count;
    for (std::size_t i = first; i < end; ++i) {
      std::array<double, 4> at;
      std::ranges::transform(corners[i], at.begin(), [&](Index row) { return potentials[row]; });
      double sum = 0;
      for (std::size_t k = 0; k < 6; ++k) {
        const double drop = at[kTetEdges[k][0]] - at[kTetEdges[k][1]];
        sum += conductances.values()[i][k] * drop * drop;
      }
      element_heat[i] = sum;
      corner_heat[i] = sum / corner_count(region().elements[i]);
    }
  });
  system.sum_at_corners(corner_heat, heat);
  for (const PatchVertex& seed : around.seeds()) {
    const Index row = around.row_of(seed.vertex);
    const double drop = 1 - potentials[row];
    heat[row] += sources[row] * drop * drop;
  }
  report.conductance = std::accumulate(heat.begin(), heat.end(), 0.0);
}

}  // namespace pbdsurg
