// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/quality.h"

#include <Eigen/Geometry>
#include <cmath>

#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/vertex_ids.h"

namespace pbdsurg {
namespace {

/// Normals of the four triangles, twice their area long, all out of or all into the tetrahedron.
std::array<Eigen::Vector3d, 4> face_normals(std::span<const Eigen::Vector3d> positions,
                                            const Tet& tet) {
  std::array<Eigen::Vector3d, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& [i, j, k] = kTetTriangles[f];
    const Eigen::Vector3d& a = positions[tet[i]];
    normals[f] = (positions[tet[j]] - a).cross(positions[tet[k]] - a);
  }
  return normals;
}

}  // namespace

std::array<double, 6> dihedral_angles(std::span<const Eigen::Vector3d> positions, const Tet& tet) {
  const std::array<Eigen::Vector3d, 4> normals = face_normals(positions, tet);
  std::array<double, 6> angles;
  for (std::size_t e = 0; e < 6; ++e) {
    // edge e joins the two vertices whose opposite triangles do not meet there; the other two do
    const auto& [i, j] = kTetEdges[5 - e];
    const Eigen::Vector3d& a = normals[i];
    const Eigen::Vector3d& b = normals[j];
    // accurate near 0 and pi, where the arc cosine is not
    angles[e] = std::atan2(a.cross(b).norm(), -a.dot(b));
  }
  return angles;
}

double radius_ratio(std::span<const Eigen::Vector3d> positions, const Tet& tet) {
  const Eigen::Vector3d& origin = positions[tet[0]];
  const Eigen::Vector3d a = positions[tet[1]] - origin;
  const Eigen::Vector3d b = positions[tet[2]] - origin;
  const Eigen::Vector3d c = positions[tet[3]] - origin;
  const double volume = std::abs(a.cross(b).dot(c)) / 6;
  double area = 0;
  for (const Eigen::Vector3d& normal : face_normals(positions, tet)) {
    area += normal.norm() / 2;
  }
  // inscribed radius 3 V / area; circumscribed radius `moment` / 12 V
  const double moment =
      (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b))
          .norm();
  const double denominator = area * moment;
  return denominator > 0 ? 108 * volume * volume / denominator : 0;
}

std::vector<Index> count_vertex_tets(Index vertex_count, std::span<const Tet> tets) {
  check_vertex_ids(vertex_count, tets);
  std::vector<Index> counts(static_cast<std::size_t>(vertex_count), 0);
  for (const Tet& tet : tets) {
    for (const Index v : tet) {
      ++counts[v];
    }
  }
  return counts;
}

std::vector<double> edge_lengths(std::span<const Eigen::Vector3d> positions,
                                 std::span<const Edge> edges) {
  check_vertex_ids(static_cast<Index>(positions.size()), edges);
  std::vector<double> lengths;
  lengths.reserve(edges.size());
  for (const Edge& edge : edges) {
    lengths.push_back((positions[edge[1]] - positions[edge[0]]).norm());
  }
  return lengths;
}

}  // namespace pbdsurg
