// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/outer_surface.h"

#include <Eigen/Geometry>
#include <vector>

#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {

MeshData outer_surface(std::span<const Eigen::Vector3d> positions, std::span<const Tet> tets) {
  std::vector<Triangle> boundary;
  for (const BoundaryTriangle& triangle : find_boundary(tets)) {
    boundary.push_back(triangle.vertices);
  }
  const Components shells = find_components(static_cast<Index>(positions.size()), boundary);
  std::vector<double> volume(static_cast<std::size_t>(shells.count), 0);
  for (const auto& [a, b, c] : boundary) {
    // relative to a point of the body: a sum about a far origin would lose its digits
    const Eigen::Vector3d& origin = positions[boundary[0][0]];
    volume[shells.of_vertex[a]] +=
        (positions[a] - origin).cross(positions[b] - origin).dot(positions[c] - origin);
  }
  MeshData surface;
  std::vector<Index> new_id(positions.size(), kInvalidIndex);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (shells.of_vertex[v] != kInvalidIndex && volume[shells.of_vertex[v]] > 0) {
      new_id[v] = static_cast<Index>(surface.points.size());
      surface.points.push_back(positions[v]);
    }
  }
  for (const auto& [a, b, c] : boundary) {
    if (new_id[a] != kInvalidIndex) {
      surface.triangles.push_back({new_id[a], new_id[b], new_id[c]});
    }
  }
  return surface;
}

}  // namespace pbdsurg
