// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Isosurface stuffing: tetrahedra of bounded dihedral angles from an implicit shape.
///
/// Labelle and Shewchuk 2007, "Isosurface stuffing: fast tetrahedral meshes with good dihedral
/// angles", on a uniform body-centred cubic lattice, with their warping constants for a uniform
/// mesh.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/implicit_shape.h"

namespace pbdsurg {

/// Tetrahedra of positive volume and the points they use, both in lattice order.
struct StuffedMesh {
  std::vector<Eigen::Vector3d> points;  ///< [point_count] m
  std::vector<Tet> tets;                ///< [tet_count]
};

/// Fills a shape with tetrahedra. Boundary points lie on the surface; nothing is smoothed, and the
/// result may be empty, in pieces or pinched where the shape is thinner than the lattice.
///
/// @param spacing    m, lattice cell
/// @param shift      part of a cell by which the lattice is moved, each in [0, 1)
/// @param max_cells  most lattice cells that may hold or touch the shape
/// @throws InvalidArgument  if the bounds are infinite or too small, if more cells would be needed,
///                          or if a value is not finite or changes too fast to be distance-like
[[nodiscard]] StuffedMesh stuff(const ImplicitShape& shape, double spacing,
                                const Eigen::Vector3d& shift, std::int64_t max_cells);

}  // namespace pbdsurg
