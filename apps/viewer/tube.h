// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Surfaces of swept circles: instruments, and tubular tissue that a solver keeps as a line.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace cholecystectomy {

/// Triangles, wound outwards.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;    ///< [vertex_count] m
  std::vector<pbdsurg::Triangle> triangles;  ///< [triangle_count] vertex ids
};

/// Sweeps a circle along a polyline and closes its ends with half spheres. The frame is carried
/// along without twist. Points that are not finite or repeat their predecessor are left out; fewer
/// than two points give an empty mesh.
///
/// @param points  [point_count] m
/// @param radii   [point_count] m
/// @throws pbdsurg::InvalidArgument  if the arrays differ in length
[[nodiscard]] TriangleMesh sweep_tube(std::span<const Eigen::Vector3f> points,
                                      std::span<const float> radii);

/// Area-weighted unit normals, zero where no finite triangle of positive area touches the vertex.
/// @return  [positions.size()]
[[nodiscard]] std::vector<Eigen::Vector3f> vertex_normals(
    std::span<const Eigen::Vector3f> positions, std::span<const pbdsurg::Triangle> triangles);

}  // namespace cholecystectomy
