// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sheets, and their triangles at rest.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/scene.h"

namespace pbdsurg {

[[nodiscard]] inline bool is_sheet(const Body& body) noexcept {
  return body.thickness > 0;
}

/// m^2
[[nodiscard]] inline double triangle_area(std::span<const Eigen::Vector3d> positions,
                                          const Triangle& triangle) {
  const Eigen::Vector3d& a = positions[triangle[0]];
  return (positions[triangle[1]] - a).cross(positions[triangle[2]] - a).norm() / 2;
}

/// kg, of a triangle of a sheet
[[nodiscard]] inline double triangle_mass(const Body& sheet,
                                          std::span<const Eigen::Vector3d> positions,
                                          const Triangle& triangle) {
  return double{sheet.material.density} * double{sheet.thickness} *
         triangle_area(positions, triangle);
}

}  // namespace pbdsurg
