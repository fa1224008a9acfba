// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Elements as local systems take them.

#include <algorithm>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"

namespace pbdsurg {

/// Rows at the corners of an element; a triangle repeats its last.
/// @param rows  [vertex_count of the mesh]
inline Tet system_corners(const ThermalMesh& mesh, Index element, std::span<const Index> rows) {
  const std::span<const Index> corners = mesh.corners(element);
  Tet found;
  found.fill(rows[corners.back()]);
  std::ranges::transform(corners, found.begin(), [&](Index vertex) { return rows[vertex]; });
  return found;
}

}  // namespace pbdsurg
