// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/potential_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/heat/local_system.h"
#include "lib/heat/system_corners.h"

namespace pbdsurg {
namespace {

// Fewer rows a group would cost more than they save.
constexpr std::size_t kLeastRowsPerGroup = 32;

// Halves `order` across the longest side of its box, again and again; appends where parts start.
void bisect(std::span<const Eigen::Vector3d> positions, std::span<const Index> vertices,
            std::span<Index> order, Index first, Index parts, std::vector<Index>& starts) {
  if (parts == 1) {
    starts.push_back(first);
    return;
  }
  Eigen::AlignedBox3d box;
  for (const Index i : order) {
    box.extend(positions[vertices[i]]);
  }
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](Index a, Index b) {
                     const double x = positions[vertices[a]][axis];
                     const double y = positions[vertices[b]][axis];
                     return x < y || (x == y && vertices[a] < vertices[b]);
                   });
  bisect(positions, vertices, order.first(half), first, parts / 2, starts);
  bisect(positions, vertices, order.subspan(half), first + static_cast<Index>(half), parts / 2,
         starts);
}

}  // namespace

void PotentialRegion::clear() {
  vertices.clear();
  is_ground.clear();
  elements.clear();
  corners.clear();
  insulators.clear();
  group_starts.clear();
  piece_count = 0;
  has_ground = false;
  has_triangles = false;
}

void RegionSearch::start(const ThermalMesh& mesh, PotentialRegion& region) {
  seen_vertices_.resize(static_cast<std::size_t>(mesh.vertex_count()));
  rows_.resize(static_cast<std::size_t>(mesh.vertex_count()));
  seen_elements_.resize(mesh.tet_count(), mesh.triangle_count());
  ++round_;
  region.clear();
}

bool RegionSearch::meet(Index vertex, PotentialRegion& region) {
  if (seen_vertices_[vertex] == round_) {
    return false;
  }
  seen_vertices_[vertex] = round_;
  region.vertices.push_back(vertex);
  return true;
}

void RegionSearch::visit(const ThermalMesh& mesh, Index element, double conductivity,
                         PotentialRegion& region) {
  if (seen_elements_[element] == round_) {
    return;
  }
  seen_elements_[element] = round_;
  check_conductivity(element, conductivity);
  if (conductivity == 0) {
    region.insulators.push_back(element);
    return;
  }
  region.elements.push_back(element);
  region.has_triangles |= is_triangle(element);
  for (const Index v : mesh.corners(element)) {
    meet(v, region);
  }
}

void RegionSearch::finish(const ThermalMesh& mesh, PotentialRegion& region) {
  const std::size_t rows = region.vertices.size();
  order_.resize(rows);
  std::iota(order_.begin(), order_.end(), 0);
  Index groups = 1;
  while (groups < LocalSystem::kMostGroups &&
         rows >= 2 * kLeastRowsPerGroup * static_cast<std::size_t>(groups)) {
    groups *= 2;
  }
  bisect(mesh.rest_positions(), region.vertices, order_, 0, groups, region.group_starts);
  region.group_starts.push_back(static_cast<Index>(rows));

  found_.swap(region.vertices);
  ground_.swap(region.is_ground);
  region.vertices.resize(rows);
  region.is_ground.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    region.vertices[row] = found_[order_[row]];
    region.is_ground[row] = ground_[order_[row]];
    rows_[region.vertices[row]] = static_cast<Index>(row);
  }
  region.corners.resize(region.elements.size());
  for (std::size_t i = 0; i < region.elements.size(); ++i) {
    region.corners[i] = system_corners(mesh, region.elements[i], rows_);
  }
}

void check_vertex(const char* what, Index vertex, Index count) {
  if (vertex < 0 || vertex >= count) {
    throw InvalidArgument(std::string(what) + " has vertex " + std::to_string(vertex) +
                          "; ids must be in [0, " + std::to_string(count) + ")");
  }
}

void refuse_conductivity(Index element, double conductivity) {
  throw InvalidArgument((is_triangle(element)
                             ? "triangle " + std::to_string(triangle_of_element(element))
                             : "tet " + std::to_string(element)) +
                        " has an electrical conductivity of " + std::to_string(conductivity) +
                        " S/m; it must be >= 0 and finite");
}

}  // namespace pbdsurg
