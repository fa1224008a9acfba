// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/potential_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "pbdsurg/core/error.h"
#include "pbdsurg/edit/compaction.h"
#include "pbdsurg/mesh/topology.h"

#include "coloring/thread_team.h"
#include "core/check.h"
#include "edit/renumbering.h"
#include "solver/step_team.h"
#include "thermal/device_system.h"
#include "thermal/local_system.h"
#include "thermal/potential_region.h"

namespace pbdsurg {
namespace {

constexpr double kHeld = std::numeric_limits<double>::infinity();

// A region is kept while the patch stays in its middle, as shares of its radius.
constexpr double kMostShift = 0.2;
constexpr double kMostGrowth = 1.25;

// Below this, an automatic choice leaves a region to the CPU. A guess, until measured.
constexpr std::size_t kRowsWorthDevice = 600;

constexpr double kLeastShare = 0.1;  // of a tetrahedron's volume at rest

// Share of a body's longest side: what its vertices reach beyond from wherever the centre is.
constexpr double kLargestRadius = 0.45;

// A vertex with the spreading resistance R = r / K_ii of a disk of the vertex's area: r = 1.5 on a
// flat surface of cubes, where K_ii = 3 sigma h and R = 1 / (4 sigma 0.5 h).
constexpr double kVertexResistance = 1.5;

// Weight from which a vertex counts as touched whole: next to 1 the conductance of a part would be
// so large that the residual's tolerance, which is relative, would mean nothing.
constexpr double kWhole = 0.99;

void check_id(const char* what, Index vertex, Index count) {
  if (vertex < 0 || vertex >= count) {
    throw InvalidArgument(std::string(what) + " has vertex " + std::to_string(vertex) +
                          "; ids must be in [0, " + std::to_string(count) + ")");
  }
}

template <class T>
void check_size(const char* what, std::span<T> values, Index count) {
  if (values.size() != static_cast<std::size_t>(count)) {
    throw InvalidArgument(std::string(what) + " has " + std::to_string(values.size()) +
                          " entries; it must have " + std::to_string(count));
  }
}

PotentialOptions checked(PotentialOptions options) {
  check(options.region_radii > 1 && std::isfinite(options.region_radii), "region_radii",
        options.region_radii, "> 1 and finite");
  check(options.tolerance > 0 && options.tolerance < 1, "tolerance", options.tolerance,
        "in (0, 1)");
  check(options.most_iterations >= 0, "most_iterations", options.most_iterations, ">= 0");
  check(options.conductivity_change >= 0, "conductivity_change", options.conductivity_change,
        ">= 0");
  options.threads = resolve_threads(options.threads);
  return options;
}

// As ThermalMesh::edge_coefficients(), of a tetrahedron that may be flat, inverted or a point:
// gradients are inward area vectors of faces over three volumes, so that with any volume > 0 the
// sums remain those of a positive semidefinite matrix, which is zero for uniform potentials.
std::array<double, 6> current_coefficients(std::span<const Eigen::Vector3f> positions,
                                           const Tet& tet, double rest_volume) {
  std::array<Eigen::Vector3d, 4> x;
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = positions[tet[i]].cast<double>();
  }
  std::array<Eigen::Vector3d, 4> areas;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [a, b, c] = kTetTriangles[i];
    areas[i] = 0.5 * (x[b] - x[a]).cross(x[c] - x[a]);
  }
  const double volume = std::abs((x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0])) / 6;
  double longest = 0;
  for (const auto& [a, b] : kTetEdges) {
    longest = std::max(longest, (x[a] - x[b]).norm());
  }
  const double counted = std::max(
      {volume, kLeastShare * rest_volume, ThermalMesh::kLeastVolume * longest * longest * longest});
  std::array<double, 6> coefficients{};
  if (!(longest > 0)) {
    return coefficients;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [a, b] = kTetEdges[k];
    coefficients[k] = -areas[a].dot(areas[b]) / (9 * counted);
  }
  return coefficients;
}

constexpr double kUnknown = -1;  // potential

// Where the electrode touches: a disk of the same size, for what is known before solving.
struct Contact {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m, of the contact or what the mesh resolves
  double reach = 0;                                  // m, of the region
  double edge = 0;                                   // m, of the mesh there

  // Potential of a disk on a half-space along its axis, zero from the reach on.
  [[nodiscard]] double guess(const Eigen::Vector3d& point) const {
    return std::max(0.0,
                    1 - std::atan((point - centre).norm() / radius) / std::atan(reach / radius));
  }
};

// S, between the electrode and a vertex that it touches in part, less than kWhole: for what the
// resistance of a disk of that part exceeds that of a disk of all of it.
double film(const PatchVertex& touched, double coupling_sum) {
  const double root = std::sqrt(touched.weight);
  return coupling_sum / kVertexResistance * root / (1 - root);
}

}  // namespace

struct PotentialField::Work {
  Work(const ThermalMesh& of, const PotentialOptions& wanted)
      : mesh(of),
        options(checked(wanted)),
        team(options.threads, options.wait),
        device(make_device_system(options.backend)) {}

  void check_numbering() const;
  void find_seeds(std::span<const double> conductivities);
  [[nodiscard]] Contact measure_contact() const;
  [[nodiscard]] bool suits(const Contact& now, std::span<const double> conductivities) const;
  [[nodiscard]] bool is_seed(Index vertex) const;
  [[nodiscard]] bool is_given_ground(Index vertex) const;
  [[nodiscard]] bool overrides_ground() const;
  void find_region(const Contact& now, std::span<const double> conductivities);
  void enter_region(const Contact& now);
  [[nodiscard]] bool moves_to_device();
  void leave_region();
  void forget();
  [[nodiscard]] bool has_moved(std::span<const Eigen::Vector3f> positions) const;
  bool update_conductances(std::span<const double> conductivities,
                           std::span<const Eigen::Vector3f> positions, bool is_region_new);
  LinearSolveReport solve_system();
  void solve(const Contact& now);
  void sum_heat();

  const ThermalMesh& mesh;
  int renumberings = mesh.renumberings();  // that this has gone along with
  PotentialOptions options;
  StepTeam team;
  LocalSystem system{&team};
  std::unique_ptr<DeviceSystem> device;  // null: none
  bool is_on_device = false;             // this region

  std::vector<PatchVertex> patch, new_patch;  // ascending
  std::vector<PatchVertex> seeds;             // of the patch, those with tissue that conducts
  double area = 0;                            // m^2
  std::vector<Index> ground;                  // ascending; none: the ball
  std::vector<double> sides;                  // [tissue_count] m, longest

  bool is_patch_new = true;
  bool is_region_old = true;
  bool has_overridden_ground = false;  // when the region was found
  std::uint64_t version = 0;           // of the mesh when the region was found
  RegionSearch search;
  PotentialRegion region, next;
  Contact region_contact;  // when the region was found

  std::vector<double> used;  // [tet_count] S/m
  // [tet_count] S; on the device m, for `used` comes with each solution
  std::vector<std::array<double, 6>> conductances;
  std::vector<Index> changed_rows;
  std::vector<char> is_changed;                 // [row_count]
  std::vector<Eigen::Vector3f> used_positions;  // [row_count] m, or empty: at rest

  std::vector<double> added, sources, potentials, heat;  // [row_count]
  std::vector<double> tet_heat;                          // [tet_count]
  std::vector<double> last;  // [vertex_count] potentials, for the next region
  PotentialReport report;
};

PotentialField::PotentialField(const ThermalMesh& mesh, const PotentialOptions& options)
    : work_(std::make_unique<Work>(mesh, options)) {
  std::vector<Eigen::AlignedBox3d> boxes(mesh.tissues().size());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.tissue_of_vertex(v) != kInvalidIndex) {
      boxes[mesh.tissue_of_vertex(v)].extend(mesh.rest_positions()[v]);
    }
  }
  for (const Eigen::AlignedBox3d& box : boxes) {
    work_->sides.push_back(box.sizes().maxCoeff());
  }
}

PotentialField::~PotentialField() = default;

const PotentialReport& PotentialField::report() const noexcept {
  return work_->report;
}
std::span<const Index> PotentialField::vertices() const noexcept {
  return work_->region.vertices;
}
std::span<const double> PotentialField::potentials() const noexcept {
  return work_->potentials;
}
std::span<const double> PotentialField::vertex_heat() const noexcept {
  return work_->heat;
}
std::span<const Index> PotentialField::tets() const noexcept {
  return work_->region.tets;
}
std::span<const double> PotentialField::tet_heat() const noexcept {
  return work_->tet_heat;
}

void PotentialField::set_patch(std::span<const PatchVertex> patch, double area) {
  Work& work = *work_;
  work.check_numbering();
  if (!patch.empty()) {
    check(area > 0 && std::isfinite(area), "contact area", area, "positive and finite");
  }
  for (const PatchVertex& touched : patch) {
    check_id("electrode patch", touched.vertex, work.mesh.vertex_count());
    if (!(touched.weight > 0) || !(touched.weight <= 1)) {
      throw InvalidArgument("electrode patch has a weight of " + std::to_string(touched.weight) +
                            " at vertex " + std::to_string(touched.vertex) +
                            "; it must be in (0, 1]");
    }
  }
  work.new_patch.assign(patch.begin(), patch.end());
  std::sort(work.new_patch.begin(), work.new_patch.end(),
            [](const PatchVertex& a, const PatchVertex& b) { return a.vertex < b.vertex; });
  for (std::size_t i = 1; i < work.new_patch.size(); ++i) {
    if (work.new_patch[i].vertex == work.new_patch[i - 1].vertex) {
      throw InvalidArgument("electrode patch has vertex " +
                            std::to_string(work.new_patch[i].vertex) + " twice");
    }
  }
  const auto same = [](const PatchVertex& a, const PatchVertex& b) {
    return a.vertex == b.vertex && a.weight == b.weight;
  };
  if (area != work.area || !std::equal(work.new_patch.begin(), work.new_patch.end(),
                                       work.patch.begin(), work.patch.end(), same)) {
    work.patch.swap(work.new_patch);
    work.area = area;
    work.is_patch_new = true;
  }
}

void PotentialField::set_ground(std::span<const Index> vertices) {
  Work& work = *work_;
  work.check_numbering();
  for (const Index v : vertices) {
    check_id("ground", v, work.mesh.vertex_count());
  }
  work.ground.assign(vertices.begin(), vertices.end());
  std::sort(work.ground.begin(), work.ground.end());
  work.is_region_old = true;
}

const PotentialReport& PotentialField::solve(std::span<const double> conductivities,
                                             std::span<const Eigen::Vector3f> positions) {
  Work& work = *work_;
  work.check_numbering();
  check_size("conductivities", conductivities, work.mesh.tet_count());
  if (!positions.empty()) {
    check_size("positions", positions, work.mesh.vertex_count());
  }
  work.find_seeds(conductivities);
  if (work.seeds.empty()) {
    work.report = {};
    work.report.lost_count = static_cast<Index>(work.patch.size());
    work.leave_region();
    return work.report;
  }
  const Contact now = work.measure_contact();
  const bool is_region_new = !work.suits(now, conductivities);
  if (is_region_new) {
    work.find_region(now, conductivities);
  }
  for (const Index v : (is_region_new ? work.next : work.region).vertices) {
    if (!positions.empty() && !positions[v].allFinite()) {
      throw InvalidArgument("vertex " + std::to_string(v) + " has a position that is not finite");
    }
  }
  try {
    if (is_region_new) {
      work.enter_region(now);
    }
    const bool is_changed = work.update_conductances(conductivities, positions, is_region_new);
    work.report.is_new = is_changed || work.is_patch_new;
    if (work.report.is_new) {
      work.solve(now);
      work.sum_heat();
    }
  } catch (const Error&) {  // the device failed
    work.report = {};
    work.leave_region();
    throw;
  }
  return work.report;
}

void PotentialField::renumber(const Renumbering& ids) {
  Work& work = *work_;
  if (work.mesh.renumberings() != work.renumberings + 1) {
    throw InvalidArgument(
        "a potential field goes along with a compaction once, after its mesh has");
  }
  std::vector<PatchVertex> patch = work.patch;
  std::vector<Index> ground = work.ground;
  const auto renumber_vertex = [&](const char* what, Index& v) {
    v = new_id(v, ids.vertices);
    if (v != kInvalidIndex) {
      check_id(what, v, work.mesh.vertex_count());
    }
  };
  for (PatchVertex& touched : patch) {
    renumber_vertex("after the compaction, the electrode patch", touched.vertex);
  }
  for (Index& v : ground) {  // what is gone stays in it, or the ball might take its place
    renumber_vertex("after the compaction, ground", v);
  }
  std::erase_if(patch, [](const PatchVertex& p) { return p.vertex == kInvalidIndex; });
  std::ranges::sort(patch, {}, &PatchVertex::vertex);
  std::ranges::sort(ground);
  work.patch = std::move(patch);
  work.ground = std::move(ground);
  work.is_patch_new = true;
  work.leave_region();
  work.report = {};
  ++work.renumberings;
}

void PotentialField::Work::check_numbering() const {
  if (renumberings != mesh.renumberings()) {
    throw InvalidArgument(
        "the mesh of a potential field has gone along with a compaction; the "
        "field must, too");
  }
}

// Those of the patch that conduct.
void PotentialField::Work::find_seeds(std::span<const double> conductivities) {
  seeds.clear();
  for (const PatchVertex& touched : patch) {
    bool conducts = false;
    if (touched.vertex < mesh.vertex_count()) {  // else an undo took it away
      mesh.for_each_tet(touched.vertex, [&](Index t) {
        check_conductivity(t, conductivities[t]);
        conducts |= conductivities[t] > 0;
      });
    }
    if (conducts) {
      seeds.push_back(touched);
    }
  }
}

Contact PotentialField::Work::measure_contact() const {
  const std::span<const Eigen::Vector3d> points = mesh.rest_positions();
  Contact now;
  double weights = 0, lengths = 0, edges = 0;
  for (const PatchVertex& seed : seeds) {
    now.centre += seed.weight * points[seed.vertex];
    weights += seed.weight;
    mesh.for_each_tet(seed.vertex, [&](Index t) {
      for (const auto& [a, b] : kTetEdges) {
        lengths += (points[mesh.tets()[t][a]] - points[mesh.tets()[t][b]]).norm();
        ++edges;
      }
    });
  }
  now.centre /= weights;
  now.edge = lengths / edges;
  now.radius = std::max(std::sqrt(area / std::numbers::pi), 0.5 * now.edge);
  now.reach = std::min(options.region_radii * now.radius,
                       kLargestRadius * sides[mesh.tissue_of_vertex(seeds.front().vertex)]);
  for (const PatchVertex& seed : seeds) {
    now.reach = std::max(now.reach, 1.5 * (points[seed.vertex] - now.centre).norm());
  }
  return now;
}

// Whether the region is what a search would find, but for a shift of the ball.
bool PotentialField::Work::suits(const Contact& now, std::span<const double> conductivities) const {
  if (is_region_old || version != mesh.version()) {
    return false;
  }
  const auto conducts = [&](Index t) {
    check_conductivity(t, conductivities[t]);
    return conductivities[t] > 0;
  };
  if (!std::all_of(region.tets.begin(), region.tets.end(), conducts) ||
      std::any_of(region.insulators.begin(), region.insulators.end(), conducts)) {
    return false;
  }
  if (!is_patch_new) {
    return true;
  }
  const double growth = now.reach / region_contact.reach;
  const bool is_in_middle =
      growth <= kMostGrowth && growth >= 1 / kMostGrowth &&
      (now.centre - region_contact.centre).norm() <= kMostShift * region_contact.reach;
  return region.piece_count == 1 &&
         (ground.empty() ? is_in_middle : !has_overridden_ground && !overrides_ground()) &&
         std::all_of(seeds.begin(), seeds.end(), [&](const PatchVertex& seed) {
           const Index row = search.row_of(seed.vertex);
           return row != kInvalidIndex && region.is_ground[row] == 0;
         });
}

bool PotentialField::Work::is_seed(Index vertex) const {
  const auto found =
      std::lower_bound(seeds.begin(), seeds.end(), vertex,
                       [](const PatchVertex& seed, Index v) { return seed.vertex < v; });
  return found != seeds.end() && found->vertex == vertex;
}

bool PotentialField::Work::is_given_ground(Index vertex) const {
  return std::binary_search(ground.begin(), ground.end(), vertex);
}

bool PotentialField::Work::overrides_ground() const {
  return std::any_of(seeds.begin(), seeds.end(),
                     [&](const PatchVertex& seed) { return is_given_ground(seed.vertex); });
}

void PotentialField::Work::find_region(const Contact& now, std::span<const double> conductivities) {
  is_region_old = true;  // its rows are lost if the search throws
  const std::span<const Eigen::Vector3d> points = mesh.rest_positions();
  search.find(
      mesh, seeds,
      [&](Index v) {
        return ground.empty() ? (points[v] - now.centre).norm() >= now.reach
                              : is_given_ground(v) && !is_seed(v);
      },
      conductivities, next);
}

void PotentialField::Work::enter_region(const Contact& now) {
  last.resize(static_cast<std::size_t>(mesh.vertex_count()), kUnknown);
  for (std::size_t row = 0; row < region.vertices.size(); ++row) {
    if (region.vertices[row] < mesh.vertex_count()) {
      last[region.vertices[row]] = potentials[row];
    }
  }
  potentials.resize(next.vertices.size());
  for (std::size_t row = 0; row < next.vertices.size(); ++row) {
    potentials[row] = last[next.vertices[row]];
  }
  forget();
  std::swap(region, next);
  region_contact = now;
  version = mesh.version();
  has_overridden_ground = overrides_ground();
  is_region_old = false;
  system.set_rows(static_cast<Index>(region.vertices.size()), region.corners);
  system.set_groups(region.group_starts);
  is_on_device = moves_to_device();
}

bool PotentialField::Work::moves_to_device() {
  return device != nullptr &&
         (options.backend == FieldBackend::cuda || region.vertices.size() >= kRowsWorthDevice) &&
         device->set_rows(system.rows(), region.corners);
}

void PotentialField::Work::forget() {
  for (const Index v : region.vertices) {
    if (v < mesh.vertex_count()) {
      last[v] = kUnknown;
    }
  }
}

// The circuit is open, and nothing is left of the last solution.
void PotentialField::Work::leave_region() {
  region.clear();
  potentials.clear();
  heat.clear();
  tet_heat.clear();
  is_region_old = true;
}

bool PotentialField::Work::has_moved(std::span<const Eigen::Vector3f> positions) const {
  if (positions.empty()) {
    return !used_positions.empty();
  }
  if (used_positions.empty()) {
    return true;
  }
  const auto most = static_cast<float>(options.conductivity_change * region_contact.edge);
  for (std::size_t row = 0; row < region.vertices.size(); ++row) {
    if ((positions[region.vertices[row]] - used_positions[row]).squaredNorm() > most * most) {
      return true;
    }
  }
  return false;
}

// Returns whether a new solution is due.
bool PotentialField::Work::update_conductances(std::span<const double> conductivities,
                                               std::span<const Eigen::Vector3f> positions,
                                               bool is_region_new) {
  const std::size_t count = region.tets.size();
  const auto conductance = [&](std::size_t i) {
    const Index t = region.tets[i];
    std::array<double, 6> values =
        positions.empty() ? mesh.edge_coefficients(t)
                          : current_coefficients(positions, mesh.tets()[t], mesh.volume(t));
    for (double& value : values) {
      value *= is_on_device ? 1 : conductivities[t];
    }
    return values;
  };
  if (is_region_new || has_moved(positions)) {
    used.resize(count);
    conductances.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      used[i] = conductivities[region.tets[i]];
      conductances[i] = conductance(i);
    }
    used_positions.resize(positions.empty() ? 0 : region.vertices.size());
    for (std::size_t row = 0; row < used_positions.size(); ++row) {
      used_positions[row] = positions[region.vertices[row]];
    }
    if (is_on_device) {
      device->set_conductances(conductances);
    } else {
      system.set_couplings(conductances);
    }
    return true;
  }
  bool is_due = false;
  for (std::size_t i = 0; i < count; ++i) {
    const double change = conductivities[region.tets[i]] - used[i];
    is_due |= std::abs(change) > options.conductivity_change * used[i];
  }
  if (!is_due && !is_patch_new) {
    return false;
  }
  if (is_on_device) {
    for (std::size_t i = 0; i < count; ++i) {
      used[i] = conductivities[region.tets[i]];
    }
    return true;
  }
  changed_rows.clear();
  is_changed.assign(region.vertices.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    if (conductivities[region.tets[i]] != used[i]) {
      used[i] = conductivities[region.tets[i]];
      conductances[i] = conductance(i);
      for (const Index row : region.corners[i]) {
        if (is_changed[row] == 0) {
          is_changed[row] = 1;
          changed_rows.push_back(row);
        }
      }
    }
  }
  system.update_couplings(conductances, changed_rows);
  return true;
}

void PotentialField::Work::solve(const Contact& now) {
  const std::size_t rows = region.vertices.size();
  const std::span<const Eigen::Vector3d> points = mesh.rest_positions();
  added.assign(rows, 0.0);
  sources.assign(rows, 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    double& start = potentials[row];
    if (region.is_ground[row] != 0) {
      start = 0;
      added[row] = kHeld;
    } else if (!region.has_ground) {
      start = 1;
    } else if (start == kUnknown) {
      start = now.guess(points[region.vertices[row]]);
    }
  }
  for (const PatchVertex& seed : seeds) {
    const Index row = search.row_of(seed.vertex);
    if (seed.weight >= kWhole) {
      added[row] = kHeld;
      potentials[row] = 1;
    } else {
      added[row] = sources[row] = film(seed, is_on_device ? 1 : system.coupling_sum(row));
    }
  }
  is_patch_new = false;
  tet_heat.assign(region.tets.size(), 0.0);
  heat.assign(rows, 0.0);
  LinearSolveReport solution;
  if (region.has_ground) {
    solution = solve_system();
  }
  report = {.is_closed = region.has_ground,
            .is_new = true,
            .iterations = solution.iterations,
            .residual = solution.residual,
            .has_converged = solution.converged,
            .vertex_count = static_cast<Index>(rows),
            .lost_count = static_cast<Index>(patch.size() - seeds.size()),
            .backend = is_on_device ? FieldBackend::cuda : FieldBackend::cpu};
}

// With its heat, on the device.
LinearSolveReport PotentialField::Work::solve_system() {
  const LinearSolveOptions how{options.tolerance, options.most_iterations};
  if (is_on_device) {
    return device->solve({used, added, sources, true, how, tet_heat, heat}, potentials);
  }
  system.set_added(added);
  return system.solve(sources, potentials, how);
}

void PotentialField::Work::sum_heat() {
  if (!region.has_ground) {
    return;
  }
  if (is_on_device) {
    report.conductance = std::accumulate(heat.begin(), heat.end(), 0.0);
    return;
  }
  team.run([&](int thread) {
    const std::size_t count = region.tets.size();
    const std::size_t first = count * thread / team.size();
    const std::size_t last_tet = count * (thread + 1) / team.size();
    for (std::size_t i = first; i < last_tet; ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        const auto [a, b] = kTetEdges[k];
        const double drop = potentials[region.corners[i][a]] - potentials[region.corners[i][b]];
        tet_heat[i] += conductances[i][k] * drop * drop;
      }
    }
  });
  system.sum_at_corners(tet_heat, heat);
  for (double& watts : heat) {
    watts /= 4;
  }
  for (const PatchVertex& seed : seeds) {
    const Index row = search.row_of(seed.vertex);
    const double drop = 1 - potentials[row];
    heat[row] += sources[row] * drop * drop;
  }
  report.conductance = std::accumulate(heat.begin(), heat.end(), 0.0);
}

}  // namespace pbdsurg
