// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which triangle is nearest to a point, and on which side of the surface the point is.

#include <Eigen/Core>
#include <limits>
#include <span>

#include "pbdsurg/contact/contact_patch.h"

namespace pbdsurg {

/// Of triangles around a point.
struct NearestTriangle {
  const PatchTriangle* triangle = nullptr;             ///< null: there is none
  Eigen::Vector3f on{0, 0, 0};                         ///< m, its nearest point
  Eigen::Vector3f away{0, 0, 0};                       ///< m, from there to the point
  float distance = std::numeric_limits<float>::max();  ///< m, negative inside
};

/// m: what rounding may be of distances, in scenes of metres.
inline constexpr float kDistanceRounding = 1e-6F;

/// m: the most that counts as the same distance.
[[nodiscard]] constexpr float tied_with(float distance) noexcept {
  return distance * (1 + 5e-5F) + kDistanceRounding;
}

/// Whether some of a triangle may be as near to a point as a distance.
/// @param distance  m, not negative
[[nodiscard]] inline bool may_reach(const PatchTriangle& triangle, const Eigen::Vector3f& point,
                                    float distance) noexcept {
  const float far = distance + triangle.size + kDistanceRounding;
  return (triangle.corners[0] - point).squaredNorm() <= far * far;
}

/// The first of those at the least distance. The side is that of all triangles at the nearest
/// point, as at an acute edge one of two faces away: by the sum of their normals, weighted with
/// angles (Baerentzen and Aanaes, "Signed distance computation using the angle weighted
/// pseudonormal", IEEE Trans. Visualization and Computer Graphics 11(3), 2005). Sheets have
/// no inside. Triangles that are not finite are nowhere.
[[nodiscard]] NearestTriangle find_nearest_triangle(std::span<const PatchTriangle> triangles,
                                                    const Eigen::Vector3f& point) noexcept;

}  // namespace pbdsurg
