// SPDX-License-Identifier: Apache-2.0
#include "lib/contact/nearest_triangle.h"

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "lib/mesh/closest_on_triangle.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// rad, of a triangle around a point of it: all that there is within, half on an edge
double angle_at(const std::array<Vector3d, 3>& corners, unsigned on_corners) {
  if (std::popcount(on_corners) > 1) {
    return std::popcount(on_corners) == 3 ? 2 * std::numbers::pi : std::numbers::pi;
  }
  const auto corner = static_cast<std::size_t>(std::countr_zero(on_corners));
  const Vector3d first = corners[(corner + 1) % 3] - corners[corner];
  const Vector3d second = corners[(corner + 2) % 3] - corners[corner];
  return std::atan2(first.cross(second).norm(), first.dot(second));
}

// By those triangles that have its nearest point, too.
bool is_outside(std::span<const PatchTriangle> triangles, const Vector3f& point,
                const NearestTriangle& nearest) {
  const Vector3d center = point.cast<double>(), touched = nearest.on.cast<double>();
  Vector3d outwards = Vector3d::Zero();
  for (const PatchTriangle& triangle : triangles) {
    if (!may_reach(triangle, point, tied_with(nearest.distance))) {
      continue;
    }
    const std::array<Vector3d, 3> corners{triangle.corners[0].cast<double>(),
                                          triangle.corners[1].cast<double>(),
                                          triangle.corners[2].cast<double>()};
    const TrianglePoint on = closest_on_triangle(corners[0], corners[1], corners[2], center);
    if ((on.point - touched).norm() <= double{kDistanceRounding}) {
      outwards += angle_at(corners, on.corners) *
                  (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    }
  }
  return nearest.away.cast<double>().dot(outwards) > 0;
}

}  // namespace

NearestTriangle find_nearest_triangle(std::span<const PatchTriangle> triangles,
                                      const Vector3f& point) noexcept {
  NearestTriangle nearest;
  float square = std::numeric_limits<float>::max();  // m^2
  for (const PatchTriangle& triangle : triangles) {
    if (!may_reach(triangle, point, nearest.distance)) {
      continue;
    }
    const auto& [a, b, c] = triangle.corners;
    const Vector3f on = closest_on_triangle(a, b, c, point).point;
    const Vector3f away = point - on;
    if (away.squaredNorm() < square) {
      square = away.squaredNorm();
      nearest = {&triangle, on, away, away.norm()};
    }
  }
  if (nearest.triangle != nullptr && !(nearest.triangle->thickness > 0) &&
      !is_outside(triangles, point, nearest)) {
    nearest.distance = -nearest.distance;
  }
  return nearest;
}

}  // namespace pbdsurg
