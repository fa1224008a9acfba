// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/membrane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

#include "mesh/describe.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

std::vector<Index> boundary_vertices(const TetMesh& mesh) {
  std::vector<Index> vertices;
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
    vertices.insert(vertices.end(), triangle.vertices.begin(), triangle.vertices.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

// Vertices sorted by the cubic cell they lie in.
class Cells {
 public:
  Cells(const TetMesh& mesh, double size) : mesh_(mesh), size_(size) {
    for (const Index v : boundary_vertices(mesh)) {
      sorted_.push_back({cell_of(mesh.positions()[v]), v});
    }
    std::sort(sorted_.begin(), sorted_.end());
  }

  // Nearest vertex within one cell's size, and its squared distance.
  [[nodiscard]] std::pair<Index, double> nearest(const Vector3d& point) const {
    std::pair<Index, double> best{kInvalidIndex, std::numeric_limits<double>::infinity()};
    const Cell middle = cell_of(point);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        // the three cells along z are neighbours in the order too
        const Cell first{middle[0] + dx, middle[1] + dy, middle[2] - 1};
        const Cell last{middle[0] + dx, middle[1] + dy, middle[2] + 1};
        auto entry = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(first, Index{0}));
        for (; entry != sorted_.end() && entry->first <= last; ++entry) {
          const double distance = (mesh_.positions()[entry->second] - point).squaredNorm();
          if (distance < best.second || (distance == best.second && entry->second < best.first)) {
            best = {entry->second, distance};
          }
        }
      }
    }
    return best;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  [[nodiscard]] Cell cell_of(const Vector3d& point) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) {
      // far beyond any organ, where a conversion would overflow, all cells are one
      const double index = std::clamp(std::floor(point[axis] / size_), -1e15, 1e15);
      cell[axis] = static_cast<std::int64_t>(index);
    }
    return cell;
  }

  const TetMesh& mesh_;
  double size_;
  std::vector<std::pair<Cell, Index>> sorted_;
};

}  // namespace

std::vector<MembraneLink> membrane_links(const TetMesh& first, const TetMesh& second,
                                         double max_distance) {
  if (!(max_distance > 0) || !std::isfinite(max_distance)) {
    throw InvalidArgument("the longest membrane link is " + describe(max_distance) +
                          " m; it must be positive and finite");
  }
  const Cells cells(second, max_distance);
  std::vector<MembraneLink> links;
  for (const Index v : boundary_vertices(first)) {
    const auto [nearest, squared] = cells.nearest(first.positions()[v]);
    if (squared < max_distance * max_distance) {
      links.push_back({v, nearest, std::sqrt(squared)});
    }
  }
  return links;
}

MeshData membrane_sheet(const TetMesh& first, const TetMesh& second,
                        std::span<const MembraneLink> links) {
  MeshData sheet;
  std::vector<Index> link_of(static_cast<std::size_t>(first.vertex_count()), kInvalidIndex);
  for (std::size_t i = 0; i < links.size(); ++i) {
    link_of[links[i].first] = static_cast<Index>(i);
    sheet.points.push_back(
        0.5 * (first.positions()[links[i].first] + second.positions()[links[i].second]));
  }
  for (const BoundaryTriangle& triangle : find_boundary(first.tets())) {
    const Triangle linked{link_of[triangle.vertices[0]], link_of[triangle.vertices[1]],
                          link_of[triangle.vertices[2]]};
    if (std::find(linked.begin(), linked.end(), kInvalidIndex) == linked.end()) {
      sheet.triangles.push_back(linked);
    }
  }
  return sheet;
}

}  // namespace pbdsurg
