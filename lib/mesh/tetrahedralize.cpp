// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/tetrahedralize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/describe.h"
#include "lib/mesh/boundary_check.h"
#include "lib/mesh/shape_thickness.h"
#include "lib/mesh/smoothing.h"
#include "lib/mesh/stuffing.h"
#include "lib/mesh/tet_shape.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

constexpr double kCountTolerance = 0.005;
constexpr double kWorstCountError = 0.1;
constexpr int kLatticeShifts = 4;
constexpr int kSpacingRetries = 4;
constexpr int kSearchSteps = 16;

// A search ends where the shape needs this many times the wanted vertices. A mesh with fewer may
// be sound by luck.
constexpr double kClearlyTooMany = 2;

// Where the boundary is pinched, a ball that surely holds a lattice point joins the parts.
constexpr double kBridgeRadius = 0.7;  // in cells
constexpr int kBridgeRounds = 3;
constexpr std::size_t kMostBridges = 100;

void check_options(const TetrahedralizeOptions& options) {
  const bool has_spacing = options.spacing != 0;
  if (has_spacing && (!(options.spacing > 0) || !std::isfinite(options.spacing))) {
    throw InvalidArgument("the spacing is " + describe(options.spacing) +
                          " m; it must be positive and finite");
  }
  if (options.vertex_count < 0 || (options.vertex_count == 0 && !has_spacing)) {
    throw InvalidArgument("the wanted vertex count is " + std::to_string(options.vertex_count) +
                          " and the spacing " + describe(options.spacing) +
                          " m; one of them must be positive");
  }
  if (options.smoothing_sweeps < 0 || options.smoothing_sweeps > 1000) {
    throw InvalidArgument("smoothing sweeps are " + std::to_string(options.smoothing_sweeps) +
                          "; they must be in [0, 1000]");
  }
  if (options.max_cells < 1 || options.max_cells > 500'000'000) {
    throw InvalidArgument("max_cells is " + std::to_string(options.max_cells) +
                          "; it must be in [1, 500000000]");
  }
}

// Vertices of a mesh: two for each cell inside, and those where the surface cuts lattice edges.
double expect_vertices(double volume, double area, double spacing) {
  return 2 * volume / std::pow(spacing, 3) + 1.5 * area / (spacing * spacing);
}

struct Candidate {
  ImplicitShape shape;  // with its bridges
  StuffedMesh mesh;
  BoundaryCheck check;
  std::size_t bridges = 0;
  double spacing = 0;
  int pieces = 0;
  Index dropped_tets = 0;

  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(mesh.points.size()); }
};

// Leaves the piece with most tetrahedra; of equal ones, that of the smallest vertex.
void keep_largest(Candidate& candidate, const Components& components) {
  StuffedMesh& mesh = candidate.mesh;
  std::vector<Index> size(static_cast<std::size_t>(components.count), 0);
  for (const Tet& tet : mesh.tets) {
    ++size[components.of_vertex[tet[0]]];
  }
  const auto largest =
      static_cast<Index>(std::max_element(size.begin(), size.end()) - size.begin());
  std::erase_if(mesh.tets, [&](const Tet& tet) { return components.of_vertex[tet[0]] != largest; });
  std::vector<Index> new_id(mesh.points.size(), kInvalidIndex);
  Index kept = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (components.of_vertex[v] == largest) {
      mesh.points[kept] = mesh.points[v];
      new_id[v] = kept++;
    }
  }
  mesh.points.resize(static_cast<std::size_t>(kept));
  for (Tet& tet : mesh.tets) {
    for (Index& v : tet) {
      v = new_id[v];
    }
  }
}

ImplicitShape with_bridges(const ImplicitShape& shape, const std::vector<Vector3d>& centers,
                           double radius) {
  Eigen::AlignedBox3d box = shape.bounds();
  for (const Vector3d& center : centers) {
    box.extend(sphere_shape(center, radius).bounds());
  }
  const auto value = [=](const Vector3d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3d& center : centers) {
      nearest = std::min(nearest, (p - center).squaredNorm());
    }
    return std::min(shape(p), std::sqrt(nearest) - radius);
  };
  if (!shape.has_closest_point()) {
    return ImplicitShape(value, box);
  }
  const auto closest_point = [=](const Vector3d& p) {
    Vector3d closest = shape.project(p, std::numeric_limits<double>::infinity());
    for (const Vector3d& center : centers) {
      const Vector3d from_center = closest - center;
      if (from_center.squaredNorm() < radius * radius && from_center.squaredNorm() > 0) {
        closest = center + radius * from_center.normalized();
      }
    }
    return closest;
  };
  return ImplicitShape(value, box, closest_point);
}

class Tetrahedralizer {
 public:
  Tetrahedralizer(const ShapeAtSpacing& shape_at, const TetrahedralizeOptions& options)
      : shape_at_(shape_at), options_(options) {}

  Tetrahedralization run() {
    return finish(options_.vertex_count > 0 ? search_count() : sound_mesh());
  }

 private:
  Candidate make(const ImplicitShape& shape, double spacing, int shift) {
    ++report_.meshes_made;
    // multiples of irrational-looking steps: no shift lands near another
    const Vector3d step(0.382, 0.618, 0.236);
    Vector3d offset = shift * step;
    offset -= Vector3d(offset.array().floor());
    Candidate candidate{shape, stuff(shape, spacing, offset, options_.max_cells), {}, 0, spacing, 0,
                        0};
    const Components components = find_components(candidate.vertex_count(), candidate.mesh.tets);
    candidate.pieces = components.count;
    if (components.count > 1 && options_.pieces == Pieces::largest) {
      const std::size_t all = candidate.mesh.tets.size();
      keep_largest(candidate, components);
      candidate.dropped_tets = static_cast<Index>(all - candidate.mesh.tets.size());
    }
    candidate.check = check_boundary(candidate.vertex_count(), candidate.mesh.tets);
    return candidate;
  }

  // An empty mesh is sound only in the sense that no other lattice position would help.
  bool is_sound(const Candidate& candidate) {
    const BoundaryCheck& check = candidate.check;
    if (candidate.mesh.tets.empty()) {
      problem_ = "no lattice point lies inside";
    } else if (!check.is_manifold()) {
      problem_ = "its boundary is pinched at " + std::to_string(check.pinched_edges.size()) +
                 " edges and " + std::to_string(check.pinched_vertices.size()) + " vertices";
    } else if (options_.euler && check.euler != *options_.euler) {
      problem_ = "it has the Euler number " + std::to_string(check.euler) + " in place of " +
                 std::to_string(*options_.euler) + ", so it has a hole or is torn";
    } else {
      return true;
    }
    ++report_.unsound_meshes;
    return false;
  }

  // Whether what was kept is a scrap of a shape that the lattice does not resolve.
  bool is_scrap(const Candidate& candidate, const ImplicitShape& shape) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& point : candidate.mesh.points) {
      box.extend(point);
    }
    const auto reaches_half = [&box](const Eigen::AlignedBox3d& all) {
      return box.diagonal().norm() > 0.5 * all.diagonal().norm();
    };
    const bool most_dropped =
        candidate.dropped_tets > static_cast<Index>(candidate.mesh.tets.size());
    if (!most_dropped && reaches_half(shape.bounds())) {
      return false;
    }
    const auto& thickness = thickness_at(shape, candidate.spacing);
    if (!thickness || thickness->median >= kThinnestWall * candidate.spacing ||
        (!most_dropped && reaches_half(thickness->box))) {
      return false;
    }
    problem_ = "most of the shape is lost between lattice points";
    ++report_.unsound_meshes;
    return true;
  }

  std::optional<Candidate> sound_mesh_at(double spacing) {
    const ImplicitShape shape = shape_at_(spacing);
    for (int shift = 0; shift < kLatticeShifts; ++shift) {
      Candidate candidate = make(shape, spacing, shift);
      std::vector<Vector3d> bridges;
      for (int round = 0; round < kBridgeRounds; ++round) {
        add_pinches(candidate, bridges);
        if (bridges.size() > kMostBridges || candidate.check.is_manifold()) {
          break;
        }
        ++report_.unsound_meshes;
        candidate = make(with_bridges(shape, bridges, kBridgeRadius * spacing), spacing, shift);
        candidate.bridges = bridges.size();
      }
      if (is_sound(candidate) && !is_scrap(candidate, shape)) {
        return candidate;
      }
      unsound_ = Unsound{spacing, static_cast<double>(candidate.vertex_count())};
    }
    return std::nullopt;
  }

  // Measured once for each spacing.
  const std::optional<Thickness>& thickness_at(const ImplicitShape& shape, double spacing) {
    if (measured_.spacing != spacing) {
      measured_ = Measured{spacing, measure_thickness(shape, spacing, options_.max_cells)};
    }
    return measured_.thickness;
  }

  // Whether the shape is too thin for this spacing, and a mesh that resolves it far too large.
  bool is_hopeless(double spacing) {
    const auto& thickness = thickness_at(shape_at_(spacing), spacing);
    if (!thickness || thickness->median >= kThinnestWall * spacing) {
      return false;
    }
    const double resolving = thickness->median / kThinnestWall;
    const double least_volume = 0.5 * thickness->least_area * thickness->median;
    return expect_vertices(least_volume, thickness->least_area, resolving) >
           kClearlyTooMany * options_.vertex_count;
  }

  // How thick the shape is, and what would do; empty if that was not what made a mesh unsound.
  [[nodiscard]] std::string thickness_advice() {
    if (!(unsound_.spacing > 0)) {
      return {};
    }
    const auto& measured = thickness_at(shape_at_(unsound_.spacing), unsound_.spacing);
    if (!measured || measured->thinnest >= kThinnestWall * unsound_.spacing) {
      return {};
    }
    const Thickness& thickness = *measured;
    const double needed = thickness.thinnest / kThinnestWall;
    const double count = expect_vertices(thickness.volume, thickness.area, needed);
    const bool is_measured = thickness.thinnest > kLeastDepth * unsound_.spacing;
    std::string text = "; its thinnest parts are " + describe(rounded(thickness.thinnest)) +
                       " m thick" + (is_measured ? "" : " or less") +
                       ", which takes a spacing of at most " + describe(rounded(needed)) + " m";
    if (thickness.least_area > 0) {
      text += (is_measured ? " and some " : " and at least ") +
              std::to_string(std::llround(rounded(count))) + " vertices";
    }
    if (options_.vertex_count == 0) {
      return text + "; for a spacing of " + describe(options_.spacing) +
             " m they must be at least " + describe(rounded(kThinnestWall * options_.spacing)) +
             " m thick";
    }
    if (thickness.least_area > 0 && count > options_.vertex_count) {
      // of a sheet of one area, vertices fall with the square of its thickness
      const double stretch = std::sqrt(count / options_.vertex_count);
      text += "; for " + std::to_string(options_.vertex_count) + " vertices they must be about " +
              describe(rounded(stretch * thickness.thinnest)) + " m thick";
    }
    return text;
  }

  // To two digits, for numbers that are no more exact.
  static double rounded(double value) {
    if (!(value > 0)) {
      return value;
    }
    const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
    return unit * std::round(value / unit);
  }

  static void add_pinches(const Candidate& candidate, std::vector<Vector3d>& bridges) {
    const std::vector<Vector3d>& points = candidate.mesh.points;
    for (const Index v : candidate.check.pinched_vertices) {
      bridges.push_back(points[v]);
    }
    for (const auto& [a, b] : candidate.check.pinched_edges) {
      bridges.push_back(0.5 * (points[a] + points[b]));
    }
  }

  Candidate sound_mesh() {
    double spacing = options_.spacing;
    for (int retry = 0; retry <= kSpacingRetries; ++retry, spacing *= 0.97) {
      if (auto candidate = sound_mesh_at(spacing)) {
        return std::move(*candidate);
      }
    }
    throw InvalidMesh("no sound mesh at a spacing of " + describe(options_.spacing) +
                      " m, nor in " + std::to_string(report_.meshes_made - 1) +
                      " more attempts down to " + describe(spacing / 0.97) + " m: " + problem_ +
                      "; the shape has parts too thin for it" + thickness_advice());
  }

  // Counts fall roughly with a power of the spacing between 2 (walls that follow the spacing) and 3
  // (solids). The power is taken from the last two meshes; a bracket keeps the steps honest. Where
  // no sound mesh is possible, the spacing is taken for too large.
  Candidate search_count() {
    const double wanted = options_.vertex_count;
    double spacing = options_.spacing > 0 ? options_.spacing : first_guess();
    double too_fine = 0, too_coarse = std::numeric_limits<double>::infinity();
    double power = 2.6;
    std::optional<Candidate> best;
    double last_spacing = 0, last_count = 0;
    const auto error_of = [wanted](const Candidate& candidate) {
      return std::abs(candidate.vertex_count() - wanted) / wanted;
    };
    for (int step = 0; step < kSearchSteps; ++step) {
      std::optional<Candidate> candidate = sound_mesh_at(spacing);
      double next = 0.8 * spacing;
      if (!candidate) {
        if (unsound_.vertex_count > (1 + kWorstCountError) * wanted) {
          break;  // a finer, sound mesh would have even more vertices
        }
        too_coarse = std::min(too_coarse, spacing);
        if (!best && is_hopeless(spacing)) {
          break;
        }
      } else {
        const double count = candidate->vertex_count();
        (count > wanted ? too_fine : too_coarse) = spacing;
        if (last_count > 0 && count != last_count) {
          const double slope = std::log(last_count / count) / std::log(spacing / last_spacing);
          power = std::clamp(slope, 1.7, 3.3);
        }
        last_spacing = spacing;
        last_count = count;
        next = spacing * std::pow(count / wanted, 1 / power);
        if (!best || error_of(*candidate) < error_of(*best)) {
          best = std::move(candidate);
        }
        if (error_of(*best) <= kCountTolerance) {
          break;
        }
      }
      if (!(next > too_fine && next < too_coarse)) {
        next = too_fine > 0 ? std::sqrt(too_fine * too_coarse) : 0.8 * too_coarse;
      }
      if (!(std::abs(next / spacing - 1) > 1e-6)) {
        break;  // the bracket is exhausted: counts jump here
      }
      spacing = next;
    }
    if (!best || error_of(*best) > kWorstCountError) {
      throw InvalidMesh(
          "no sound mesh with " + std::to_string(options_.vertex_count) + " vertices: " +
          (best ? "the nearest has " + std::to_string(best->vertex_count()) + ", at a spacing of " +
                      describe(best->spacing) + " m"
                : "none of " + std::to_string(report_.meshes_made) +
                      " attempts down to a spacing of " + describe(spacing) + " m is sound") +
          (problem_.empty() ? "" : "; the last failure: " + problem_) + thickness_advice());
    }
    return std::move(*best);
  }

  // As if the shape filled its box with one vertex a cell.
  double first_guess() const {
    const Eigen::AlignedBox3d box = shape_at_(1.0).bounds();
    const double volume = box.volume();
    if (!(volume > 0) || !std::isfinite(volume)) {
      throw InvalidArgument("the shape has a box from " + describe(box.min()) + " to " +
                            describe(box.max()) +
                            "; it must have a finite volume for a vertex count to be reached");
    }
    return std::cbrt(volume / options_.vertex_count);
  }

  Tetrahedralization finish(Candidate candidate) {
    const ImplicitShape& shape = candidate.shape;
    StuffedMesh& mesh = candidate.mesh;
    smooth(shape, candidate.spacing, options_.smoothing_sweeps, mesh.points, mesh.tets);
    const DihedralRange range = dihedral_range(mesh.points, mesh.tets);
    report_.spacing = candidate.spacing;
    report_.bridges = static_cast<int>(candidate.bridges);
    report_.pieces = candidate.pieces;
    report_.dropped_tets = candidate.dropped_tets;
    report_.euler = candidate.check.euler;
    report_.boundary_shells = candidate.check.shells;
    report_.min_dihedral = range.min;
    report_.max_dihedral = range.max;
    report_.thin_share = thin_share(shape, candidate.spacing, mesh);
    return {TetMesh(std::move(mesh.points), std::move(mesh.tets)), report_};
  }

  const ShapeAtSpacing& shape_at_;
  const TetrahedralizeOptions& options_;
  TetrahedralizeReport report_;
  std::string problem_;  // of the last unsound mesh
  struct Unsound {
    double spacing = 0;
    double vertex_count = 0;
  } unsound_;  // the last one
  struct Measured {
    double spacing = 0;
    std::optional<Thickness> thickness;
  } measured_;
};

}  // namespace

Tetrahedralization tetrahedralize(const ShapeAtSpacing& shape_at_spacing,
                                  const TetrahedralizeOptions& options) {
  check_options(options);
  return Tetrahedralizer(shape_at_spacing, options).run();
}

Tetrahedralization tetrahedralize(const ImplicitShape& shape,
                                  const TetrahedralizeOptions& options) {
  return tetrahedralize([&shape](double) { return shape; }, options);
}

Tetrahedralization tetrahedralize(const MeshData& surface, const TetrahedralizeOptions& options) {
  check_options(options);
  std::vector<Triangle> triangles = surface.triangles;
  if (triangles.empty()) {
    for (const BoundaryTriangle& triangle : find_boundary(surface.tets)) {
      triangles.push_back(triangle.vertices);
    }
  }
  return tetrahedralize(surface_shape(surface.points, triangles), options);
}

}  // namespace pbdsurg
