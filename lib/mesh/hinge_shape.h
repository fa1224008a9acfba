// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The shape of two triangles with a common edge, and how a plate of them bends.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/check.h"

namespace pbdsurg {

/// N m, see flexural_rigidity() of constraints/bending.h.
inline double plate_rigidity(double youngs_modulus, double thickness, double poissons_ratio) {
  return youngs_modulus * thickness * thickness * thickness /
         (12 * (1 - poissons_ratio * poissons_ratio));
}

/// |e|^2 / (A1 + A2), of the edge (x0, x1) and the triangles with x2 and with x3.
/// @param x         m
/// @param what      the hinge's name
/// @param vertices  those of its vertices
/// @throws InvalidArgument  naming the vertex or the edge, if a coordinate is not finite, or the
///                          height of a triangle over the edge, or the edge, is not more than 1e-6
///                          of the triangle's longest edge
inline double checked_hinge_shape(const Vec3<double> (&x)[4], const std::string& what,
                                  const std::array<Index, 4>& vertices) {
  const auto distance = [](const Vec3<double>& a, const Vec3<double>& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
  };
  const auto check_length = [](const std::string& name, double length, double longest) {
    constexpr double kLeastShare = 1e-6;
    if (!(length > kLeastShare * longest)) {
      throw InvalidArgument(name + " is " + describe(length) +
                            " m; it must be more than 1e-6 of the longest edge of its triangle, " +
                            describe(longest) + " m");
    }
  };
  for (int i = 0; i < 4; ++i) {
    for (const double coordinate : {x[i].x, x[i].y, x[i].z}) {
      check(std::isfinite(coordinate),
            ("a coordinate of vertex " + std::to_string(vertices[i]) + " of " + what).c_str(),
            coordinate, "finite");
    }
  }
  const double edge = distance(x[0], x[1]);
  double height_sum = 0;
  for (const int opposite : {2, 3}) {
    const double to_start = distance(x[0], x[opposite]);
    const double longest = std::max({edge, to_start, distance(x[1], x[opposite])});
    check_length("the edge of " + what, edge, longest);
    const Vec3<double> axis = (1 / edge) * (x[1] - x[0]);
    const double height = distance(cross(axis, x[opposite] - x[0]), {});
    check_length(
        "the height of vertex " + std::to_string(vertices[opposite]) + " over the edge of " + what,
        height, longest);
    height_sum += height;
  }
  return 2 * edge / height_sum;
}

}  // namespace pbdsurg
