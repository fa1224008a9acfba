// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <cmath>

#include "lib/base/check.h"
#include "lib/mesh/hinge_shape.h"

namespace pbdsurg {
HingeAtRest hinge_at_rest(const Vec3<double> (&x)[4], double rigidity) {
  check_positive("the flexural rigidity of a hinge", rigidity, " N m");
  const double stiffness = rigidity * checked_hinge_shape(x, "a hinge", {0, 1, 2, 3});
  check_positive("the stiffness of a hinge", stiffness, " N m");
  const double edge = std::hypot(x[1].x - x[0].x, x[1].y - x[0].y, x[1].z - x[0].z);
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
  return plate_rigidity(youngs_modulus, thickness, poissons_ratio);
}

}  // namespace pbdsurg
