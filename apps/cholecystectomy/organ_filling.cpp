// SPDX-License-Identifier: Apache-2.0
#include "organ_filling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pbdsurg/core/error.h"

namespace cholecystectomy {

using Eigen::Vector3d;
using pbdsurg::Organ;

double estimate_tets(Organ organ, const pbdsurg::MeshData& surface) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : surface.points) {
    centre += p / static_cast<double>(surface.points.size());
  }
  double area = 0, volume = 0;  // holes closed by cones to the centre
  for (const pbdsurg::Triangle& triangle : surface.triangles) {
    const Vector3d a = surface.points[triangle[0]] - centre;
    const Vector3d b = surface.points[triangle[1]] - centre;
    const Vector3d c = surface.points[triangle[2]] - centre;
    area += (b - a).cross(c - a).norm() / 2;
    volume += a.dot(b.cross(c)) / 6;
  }
  volume = std::abs(volume);
  if (organ == Organ::gallbladder) {  // its wall alone, which has two sides
    volume = std::min(volume, area * pbdsurg::CholecystectomyOptions{}.wall_thickness);
    area *= 2;
  }
  // twelve to a cell of the lattice, and those that its surface cuts
  const double spacing = pbdsurg::organ_recipe(organ).options.spacing;
  return 12 * volume / std::pow(spacing, 3) + 2 * area / std::pow(spacing, 2);
}

void check_tet_count(double tet_count, pbdsurg::Index max_tets, const std::string& name) {
  if (tet_count > max_tets) {
    throw pbdsurg::InvalidArgument(name + " takes about " +
                                   std::to_string(static_cast<std::int64_t>(tet_count)) +
                                   " tetrahedra; --max-tets allows " + std::to_string(max_tets) +
                                   ". Is the unit right (--unit, --scale)? `pbdsurg mesh make FILE "
                                   "OUT.msh --spacing MM` makes "
                                   "coarser tetrahedra, which are taken as they are");
  }
}

pbdsurg::TetMesh fill(Organ organ, const pbdsurg::ImplicitShape& shape, pbdsurg::Index max_tets,
                      const std::string& name) {
  try {
    pbdsurg::TetMesh mesh = pbdsurg::fill_organ(organ, shape);
    check_tet_count(static_cast<double>(mesh.tets().size()), max_tets, name);
    return mesh;
  } catch (const pbdsurg::InvalidMesh& error) {
    throw pbdsurg::InvalidMesh(name + " cannot be filled with tetrahedra: " + error.what() +
                               ". Is the unit right (--unit, --scale)? `pbdsurg mesh make FILE "
                               "OUT.msh --spacing MM` fills "
                               "at a spacing of your choice; its tetrahedra are taken as they are");
  }
}

}  // namespace cholecystectomy
