// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Meshes as they come from files and generators, before any guarantee is made.

#include <Eigen/Core>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Points with tetrahedra and triangles. Ids are in range; nothing else is promised: points may be
/// unused or repeated, tetrahedra flat or inverted, triangles open or badly wound.
struct MeshData {
  std::vector<Eigen::Vector3d> points;  ///< [point_count] in the unit of its source, m by default
  std::vector<Tet> tets;                ///< [tet_count] point ids
  std::vector<Triangle> triangles;      ///< [triangle_count] point ids
};

}  // namespace pbdsurg
