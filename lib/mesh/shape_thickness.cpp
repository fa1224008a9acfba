// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/shape_thickness.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/lattice.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

// How far the inside goes on from a point of the surface, at most `enough`.
double depth_below(const ImplicitShape& shape, const Vector3d& start, const Vector3d& inwards,
                   double least_step, double enough) {
  double depth = 0, value = 0;
  while (depth < enough) {
    const double step = std::max(-value, least_step);
    const double next = shape(start + (depth + step) * inwards);
    if (next >= 0) {
      return value < 0 ? depth + step * value / (value - next) : depth;
    }
    depth += step;
    value = next;
  }
  return enough;
}

}  // namespace

std::optional<Thickness> measure_thickness(const ImplicitShape& shape, double spacing,
                                           std::int64_t max_cells) {
  const Lattice lattice(shape, spacing, Vector3d::Zero(), max_cells);
  std::vector<Index> near;
  double inside = 0, close_by = 0, farther = 0;
  for (Index site = 0; site < lattice.site_count(); ++site) {
    const double value = lattice.value(site);
    if (std::abs(value) < spacing) {
      near.push_back(site);
    }
    inside += value < 0 ? 1 : 0;
    close_by += value >= 0 && value < 0.5 * spacing ? 1 : 0;
    farther += value >= 0.5 * spacing && value < spacing ? 1 : 0;
  }
  constexpr std::size_t kMostSamples = 2000;
  const double least_depth = kLeastDepth * spacing;
  std::vector<double> depths;
  Thickness thickness;
  for (std::size_t i = 0; i < near.size(); i += near.size() / kMostSamples + 1) {
    const Vector3d start = shape.project(lattice.position(lattice.site_at(near[i])), 2 * spacing);
    const double above = shape(start);
    if (std::abs(above) > least_depth) {
      continue;
    }
    thickness.box.extend(start);
    Vector3d outwards;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = 0.05 * spacing * Vector3d::Unit(axis);
      outwards[axis] = shape(start + step) - shape(start - step);
    }
    if (outwards.norm() > 0) {
      const double depth = depth_below(shape, start, -outwards.normalized(), least_depth,
                                       2 * kThinnestWall * spacing);
      depths.push_back(std::max(depth - above, least_depth));
    }
  }
  if (depths.empty()) {
    return std::nullopt;
  }
  std::sort(depths.begin(), depths.end());
  thickness.thinnest = depths[depths.size() / 20];
  thickness.median = depths[depths.size() / 2];
  // A layer of width w outside has the volume area w + c w^2, where c is of bends and edges. Half
  // a cell is the distance of lattice planes, so that each layer holds as many of them anywhere.
  // A cell has two lattice points.
  const double per_site = 0.5 * spacing * spacing;
  thickness.area = std::max(0.0, per_site * (3 * close_by - farther));
  thickness.least_area =
      std::max(0.0, thickness.area - 2 * per_site * std::sqrt(9 * close_by + farther));
  // what is thinner than a cell may lie between all sites
  thickness.volume = thickness.median < kThinnestWall * spacing
                         ? 0.5 * thickness.area * thickness.median
                         : 0.5 * inside * std::pow(spacing, 3);
  return thickness;
}

double thin_share(const ImplicitShape& shape, double spacing, const StuffedMesh& mesh) {
  std::vector<Vector3d> normals(mesh.points.size(), Vector3d::Zero());
  for (const auto& [triangle, tet] : find_boundary(mesh.tets)) {
    const Vector3d& origin = mesh.points[triangle[0]];
    const Vector3d area =
        (mesh.points[triangle[1]] - origin).cross(mesh.points[triangle[2]] - origin);
    for (const Index v : triangle) {
      normals[v] += area;
    }
  }
  const double enough = kThinnestWall * spacing;
  Index thin = 0, all = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (normals[v].isZero(0)) {
      continue;
    }
    ++all;
    const Vector3d inwards = -normals[v].normalized();
    double depth = 0.1 * spacing;
    double value = shape(mesh.points[v] + depth * inwards);
    while (value < 0 && depth < enough) {
      depth += std::max(-value, 0.1 * spacing);
      value = shape(mesh.points[v] + depth * inwards);
    }
    thin += depth < enough ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(thin) / all : 0;
}

}  // namespace pbdsurg
