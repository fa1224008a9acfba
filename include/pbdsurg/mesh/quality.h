// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Shape measures of tetrahedra, computed in double. None depends on the unit of length or on the
/// orientation of a tetrahedron, edge lengths excepted. Those of one tetrahedron serve inner loops:
/// they do not check its ids.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Angles between the triangles that meet at each edge, measured inside: rad, in [0, pi], in the
/// order of kTetEdges. A regular tetrahedron has acos(1/3) = 70.5 degrees at each. Where a triangle
/// has no area the angle means nothing.
[[nodiscard]] PBDSURG_API std::array<double, 6> dihedral_angles(
    std::span<const Eigen::Vector3d> positions, const Tet& tet);

/// Three times the radius of the inscribed sphere over that of the circumscribed one: 1 for a
/// regular tetrahedron, 0 for a flat one.
[[nodiscard]] PBDSURG_API double radius_ratio(std::span<const Eigen::Vector3d> positions,
                                              const Tet& tet);

/// [vertex_count] how many tetrahedra use each vertex.
/// @throws InvalidArgument  as find_vertex_tets()
[[nodiscard]] PBDSURG_API std::vector<Index> count_vertex_tets(Index vertex_count,
                                                               std::span<const Tet> tets);

/// [edge_count] m
/// @throws InvalidArgument  naming the vertex that has no position
[[nodiscard]] PBDSURG_API std::vector<double> edge_lengths(
    std::span<const Eigen::Vector3d> positions, std::span<const Edge> edges);

}  // namespace pbdsurg
