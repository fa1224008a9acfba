// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a triangle of a sheet conducts in its plane.

#include <Eigen/Core>
#include <array>

namespace pbdsurg {

/// -t A grad N_i . grad N_j, m, of the edges in the order of kTetEdges, of which those to a fourth
/// corner have none: as gradients are inward normals of edges over two heights, the dot product of
/// the other two sides at the opposite corner, over 4 A.
/// @param corners    m
/// @param thickness  m
/// @param area       m^2, positive; that of the corners, or more
inline std::array<double, 6> triangle_coefficients(const std::array<Eigen::Vector3d, 3>& corners,
                                                   double thickness, double area) {
  const auto opposite = [&](int i, int j, int k) {
    return area > 0
               ? thickness * (corners[i] - corners[k]).dot(corners[j] - corners[k]) / (4 * area)
               : 0;
  };
  return {opposite(0, 1, 2), opposite(0, 2, 1), 0, opposite(1, 2, 0), 0, 0};
}

}  // namespace pbdsurg
