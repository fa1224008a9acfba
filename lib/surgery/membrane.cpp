// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/membrane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/check.h"
#include "lib/base/describe.h"
#include "lib/mesh/point_cells.h"
#include "lib/mesh/segment_crossing.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

constexpr double kMostFibres = 1e8;
constexpr double kFacing = 0.5;  // cosine of 60 degrees

void check_two(std::span<const Vector3d> first, std::span<const Vector3d> second) {
  if (!first.empty() && first.data() == second.data()) {
    throw InvalidArgument("a body would be linked to itself; a membrane joins two");
  }
}

std::vector<Triangle> boundary_of(std::span<const Tet> tets) {
  std::vector<Triangle> triangles;
  for (const BoundaryTriangle& triangle : find_boundary(tets)) {
    triangles.push_back(triangle.vertices);
  }
  return triangles;
}

// Ascending.
std::vector<Index> vertices_of(std::span<const Triangle> triangles) {
  std::vector<Index> vertices;
  for (const Triangle& triangle : triangles) {
    vertices.insert(vertices.end(), triangle.begin(), triangle.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

// The surface of a body, to ask what a straight way of limited length leaves, enters or crosses.
class Surface {
 public:
  // What is asked for is within reach of where it is asked, m.
  Surface(const LinkedSurface& surface, double reach)
      : surface_(surface), normals_(surface.positions.size(), Vector3d::Zero()) {
    std::vector<Vector3d> centres;
    double largest = 0;  // distance of a corner from its triangle's centre
    for (const Triangle& triangle : surface.triangles) {
      const auto [a, b, c] = corners(triangle);
      centres.push_back((a + b + c) / 3);
      for (const Vector3d& corner : {a, b, c}) {
        largest = std::max(largest, (corner - centres.back()).norm());
      }
      for (const Index v : triangle) {
        normals_[v] += towards(area_vector(triangle), normals_[v]);
      }
    }
    std::vector<Index> all(surface.triangles.size());
    std::iota(all.begin(), all.end(), Index{0});
    centre_cells_ = PointCells(centres, all, reach / 2 + largest);
  }

  [[nodiscard]] std::span<const Triangle> triangles() const { return surface_.triangles; }

  [[nodiscard]] std::array<Vector3d, 3> corners(const Triangle& triangle) const {
    const auto& x = surface_.positions;
    return {x[triangle[0]], x[triangle[1]], x[triangle[2]]};
  }

  // Normal times area, outwards.
  [[nodiscard]] Vector3d area_vector(const Triangle& triangle) const {
    const auto [a, b, c] = corners(triangle);
    return (b - a).cross(c - a) / 2;
  }

  // A normal outwards; of a sheet, on the side that looks along a way.
  [[nodiscard]] Vector3d towards(const Vector3d& normal, const Vector3d& way) const {
    return surface_.is_two_sided && normal.dot(way) < 0 ? Vector3d(-normal) : normal;
  }

  // Outward at a vertex, of any length.
  [[nodiscard]] const Vector3d& normal(Index vertex) const { return normals_[vertex]; }

  // Whether the way from a vertex to a point passes through another triangle than the vertex's own.
  [[nodiscard]] bool blocks(Index vertex, const Vector3d& point) const {
    const Vector3d& start = surface_.positions[vertex];
    bool is_blocked = false;
    centre_cells_.visit_near((start + point) / 2, [&](Index t) {
      const Triangle& v = triangles()[t];
      if (!is_blocked && std::find(v.begin(), v.end(), vertex) == v.end()) {
        const auto [a, b, c] = corners(v);
        is_blocked = segment_crosses(start, point, a, b, c);
      }
    });
    return is_blocked;
  }

 private:
  const LinkedSurface& surface_;
  std::vector<Vector3d> normals_;  // [vertex_count]
  PointCells centre_cells_;
};

// A point of a triangle, each as likely.
Vector3d random_point(const std::array<Vector3d, 3>& corners, double u, double v) {
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
}

void check(const ScatterOptions& options) {
  check_positive("max_distance", options.max_distance, " m");
  check_positive("density", options.density, " fibres per m^2");
}

// Calls visit(point, area vector of its triangle, nearest corner) for points scattered at random.
template <class Visit>
void scatter(const Surface& surface, const ScatterOptions& options, Visit visit) {
  double area = 0;
  for (const Triangle& triangle : surface.triangles()) {
    area += surface.area_vector(triangle).norm();
  }
  if (!(area * options.density < kMostFibres)) {
    throw InvalidArgument("density is " + describe(options.density) +
                          " fibres per m^2, which makes " + describe(area * options.density) +
                          " on the first surface; there may be 1e8");
  }
  for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
    const Triangle& triangle = surface.triangles()[t];
    const std::array<Vector3d, 3> corners = surface.corners(triangle);
    // a fraction of a fibre is a whole one on that share of triangles
    const Vector3d area_vector = surface.area_vector(triangle);
    const auto count = static_cast<std::uint64_t>(area_vector.norm() * options.density +
                                                  random_unit(options.seed, t));
    for (std::uint64_t i = 1; i <= count; ++i) {
      const Vector3d point = random_point(corners, random_unit(options.seed, t, 2 * i),
                                          random_unit(options.seed, t, 2 * i + 1));
      const auto nearest_corner = std::min_element(
          corners.begin(), corners.end(), [&](const Vector3d& a, const Vector3d& b) {
            return (a - point).squaredNorm() < (b - point).squaredNorm();
          });
      visit(point, area_vector, triangle[nearest_corner - corners.begin()]);
    }
  }
}

// Fibres with the same ends as one link.
// @param fibres  corner of first, vertex of second
std::vector<MembraneLink> bundle(std::vector<std::pair<Index, Index>> fibres,
                                 std::span<const Vector3d> first,
                                 std::span<const Vector3d> second) {
  std::sort(fibres.begin(), fibres.end());
  std::vector<MembraneLink> links;
  for (const auto& [v, w] : fibres) {
    if (!links.empty() && links.back().first == v && links.back().second == w) {
      ++links.back().fibres;
    } else {
      links.push_back({v, w, (second[w] - first[v]).norm()});
    }
  }
  return links;
}

double longest_edge(const TetMesh& mesh) {
  double longest = 0;
  for (const auto& [a, b] : find_edges(mesh.tets())) {
    longest = std::max(longest, (mesh.positions()[b] - mesh.positions()[a]).norm());
  }
  return longest;
}

}  // namespace

LinkedSurface::LinkedSurface(const TetMesh& mesh)
    : positions(mesh.positions()), triangles(boundary_of(mesh.tets())) {}

LinkedSurface::LinkedSurface(const Scene& scene, Index body) {
  const Body& own = scene.body(body);
  const auto part = [](const auto& all, Index first, Index count) {
    return all.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
  };
  positions = part(scene.positions(), own.first_vertex, own.vertex_count);
  is_two_sided = is_sheet(own);
  if (is_two_sided) {
    const auto all = part(scene.triangles(), own.first_triangle, own.triangle_count);
    triangles.assign(all.begin(), all.end());
  } else {
    triangles = boundary_of(part(scene.tets(), own.first_tet, own.tet_count));
  }
  for (Triangle& triangle : triangles) {
    for (Index& v : triangle) {
      v -= own.first_vertex;
    }
  }
}

std::vector<MembraneLink> membrane_links(const LinkedSurface& first, const LinkedSurface& second,
                                         double max_distance) {
  check_two(first.positions, second.positions);
  check_positive("the longest membrane link", max_distance, " m");
  const auto x = second.positions;
  const PointCells cells(x, vertices_of(second.triangles), max_distance);
  std::vector<MembraneLink> links;
  for (const Index v : vertices_of(first.triangles)) {
    const Vector3d& point = first.positions[v];
    Index nearest = kInvalidIndex;
    double least = max_distance * max_distance;
    cells.visit_near(point, [&](Index w) {
      const double squared = (x[w] - point).squaredNorm();
      if (squared < least || (squared == least && w < nearest)) {
        nearest = w;
        least = squared;
      }
    });
    if (nearest != kInvalidIndex) {
      links.push_back({v, nearest, std::sqrt(least)});
    }
  }
  return links;
}

std::vector<MembraneLink> scattered_links(const LinkedSurface& first, const LinkedSurface& second,
                                          const ScatterOptions& options) {
  check_two(first.positions, second.positions);
  check(options);
  const auto x = first.positions;
  const auto y = second.positions;
  const Surface start(first, options.max_distance), end(second, options.max_distance);
  const PointCells cells(y, vertices_of(end.triangles()), options.max_distance);
  // outwards from a triangle at v, against the surface at w, and through nothing
  const auto is_open = [&](const Vector3d& area_vector, Index v, Index w) {
    const Vector3d way = y[w] - x[v];
    const Vector3d outwards = start.towards(area_vector, way);
    const Vector3d inwards = end.towards(end.normal(w), -way);
    return way.norm() < options.max_distance && outwards.dot(way) >= 0 && inwards.dot(way) <= 0 &&
           outwards.dot(inwards) < 0 && !start.blocks(v, y[w]) && !end.blocks(w, x[v]);
  };
  std::vector<std::pair<Index, Index>> fibres;
  std::vector<std::pair<double, Index>> candidates;  // squared distance, vertex of second
  scatter(start, options, [&](const Vector3d& point, const Vector3d& area_vector, Index v) {
    candidates.clear();
    cells.visit_near(x[v], [&](Index w) {
      candidates.push_back({(y[w] - point).squaredNorm(), w});
    });
    std::sort(candidates.begin(), candidates.end());
    const auto found = std::find_if(
        candidates.begin(), candidates.end(),
        [&](const auto& candidate) { return is_open(area_vector, v, candidate.second); });
    if (found != candidates.end()) {
      fibres.push_back({v, found->second});
    }
  });
  return bundle(std::move(fibres), x, y);
}

std::vector<MembraneLink> links_by_area(const TetMesh& first, const TetMesh& second,
                                        const ScatterOptions& options) {
  check_two(first.positions(), second.positions());
  check(options);
  if (first.tets().empty() || second.tets().empty()) {
    return {};
  }
  const LinkedSurface surface(first);
  const Surface start(surface, options.max_distance);
  const SurfaceDistance end(second.positions(), boundary_of(second.tets()));
  std::vector<Index> used;
  for (const Tet& tet : second.tets()) {
    used.insert(used.end(), tet.begin(), tet.end());
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  // no point of a body is farther from all of its vertices
  const PointCells cells(second.positions(), used, longest_edge(second));
  std::vector<std::pair<Index, Index>> fibres;
  scatter(start, options, [&](const Vector3d& point, const Vector3d& outwards, Index v) {
    Vector3d goal = point;
    if (end.signed_distance(point) > 0) {
      goal = end.closest_point(point);
      const double gap = (goal - point).norm();
      if (!(gap < options.max_distance) ||
          outwards.dot(goal - point) < kFacing * gap * outwards.norm()) {
        return;
      }
    }
    double least = std::numeric_limits<double>::infinity();
    Index nearest = kInvalidIndex;
    cells.visit_near(goal, [&](Index w) {
      const double squared = (second.positions()[w] - goal).squaredNorm();
      if (squared < least || (squared == least && w < nearest)) {
        least = squared;
        nearest = w;
      }
    });
    if (nearest != kInvalidIndex) {
      fibres.push_back({v, nearest});
    }
  });
  return bundle(std::move(fibres), first.positions(), second.positions());
}

MeshData membrane_sheet(const TetMesh& first, const TetMesh& second,
                        std::span<const MembraneLink> links) {
  for (const MembraneLink& link : links) {
    check_id("vertex", link.first, first.positions().size());
    check_id("vertex", link.second, second.positions().size());
  }
  MeshData sheet;
  std::vector<Index> link_of(static_cast<std::size_t>(first.vertex_count()), kInvalidIndex);
  for (std::size_t i = 0; i < links.size(); ++i) {
    link_of[links[i].first] = static_cast<Index>(i);
    sheet.points.push_back(
        0.5 * (first.positions()[links[i].first] + second.positions()[links[i].second]));
  }
  for (const auto& [a, b, c] : boundary_of(first.tets())) {
    const Triangle linked{link_of[a], link_of[b], link_of[c]};
    if (std::find(linked.begin(), linked.end(), kInvalidIndex) == linked.end()) {
      sheet.triangles.push_back(linked);
    }
  }
  return sheet;
}

}  // namespace pbdsurg
