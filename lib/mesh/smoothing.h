// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Moves points of a stuffed mesh so that its worst dihedral angles improve.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/implicit_shape.h"

namespace pbdsurg {

/// Guarded Laplacian smoothing: sweeps over the points in order, and moves each towards the mean of
/// its neighbours where that improves the worst angle of the tetrahedra around it.
///
/// Boundary points take the mean of their boundary neighbours and return to the surface of the
/// shape. No tetrahedron is ever inverted or made worse than the worst at the moved point.
/// @param points  [point_count] m
/// @note Cost: about 0.01 s per 1000 points and sweep.
void smooth(const ImplicitShape& shape, double spacing, int sweeps,
            std::span<Eigen::Vector3d> points, std::span<const Tet> tets);

}  // namespace pbdsurg
