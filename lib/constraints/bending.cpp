// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/check.h"

namespace pbdsurg {
namespace {

constexpr double kLeastShare = 1e-6;  // of a triangle's longest edge

double distance(const Vec3<double>& a, const Vec3<double>& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

void check_length(const std::string& what, double length, double longest) {
  if (!(length > kLeastShare * longest)) {
    throw InvalidArgument(what + " is " + describe(length) +
                          " m; it must be more than 1e-6 of the longest edge of its triangle, " +
                          describe(longest) + " m");
  }
}

}  // namespace

HingeAtRest hinge_at_rest(const Vec3<double> (&x)[4], double rigidity) {
  check_positive("the flexural rigidity of a hinge", rigidity, " N m");
  for (int i = 0; i < 4; ++i) {
    for (const double coordinate : {x[i].x, x[i].y, x[i].z}) {
      check(std::isfinite(coordinate),
            ("a coordinate of vertex " + std::to_string(i) + " of a hinge").c_str(), coordinate,
            "finite");
    }
  }
  const double edge = distance(x[0], x[1]);
  double height_sum = 0;
  for (const int opposite : {2, 3}) {
    const double to_start = distance(x[0], x[opposite]);
    const double longest = std::max({edge, to_start, distance(x[1], x[opposite])});
    check_length("the edge of a hinge", edge, longest);
    const Vec3<double> axis = (1 / edge) * (x[1] - x[0]);
    const double height = distance(cross(axis, x[opposite] - x[0]), {});
    check_length("the height of vertex " + std::to_string(opposite) + " over the edge of a hinge",
                 height, longest);
    height_sum += height;
  }
  // |e|^2 over the areas
  const double stiffness = rigidity * (2 * edge / height_sum);
  check_positive("the stiffness of a hinge", stiffness, " N m");
  // in units of the edge, whose square any number type holds
  const Vec3<double> shape[4] = {
      {}, (1 / edge) * (x[1] - x[0]), (1 / edge) * (x[2] - x[0]), (1 / edge) * (x[3] - x[0])};
  return {BendingConstraint::value(shape, 0.0), stiffness};
}

double flexural_rigidity(double youngs_modulus, double thickness, double poissons_ratio) {
  check_positive("Young's modulus", youngs_modulus, " Pa");
  check_positive("the thickness of a plate", thickness, " m");
  check(poissons_ratio > -1 && poissons_ratio <= 0.5, "Poisson's ratio", poissons_ratio,
        "in (-1, 0.5]");
  return youngs_modulus * thickness * thickness * thickness /
         (12 * (1 - poissons_ratio * poissons_ratio));
}

}  // namespace pbdsurg
