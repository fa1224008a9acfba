// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How fine a lattice resolves the wall of a gallbladder.

namespace pbdsurg {

/// A wall of 1 / 0.88 cells is as thin as the lattice resolves without holes; from 1 / 0.89 on
/// there are some. Nearly all vertices are then on the boundary, as in the paper's meshes, and the
/// counts of links and tetrahedra follow.
inline constexpr double kWallCellsPerThickness = 0.88;

}  // namespace pbdsurg
