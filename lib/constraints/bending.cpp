// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <cmath>
#include <cstddef>

#include "pbdsurg/mesh/topology.h"

#include "lib/base/check.h"
#include "lib/mesh/hinge_shape.h"

namespace pbdsurg {
namespace {

// rad: a hinge that is bent by less at rest is flat, as far as single precision tells.
constexpr double kFlat = 1e-5;

struct UnitHinge {
  double edge;        // m
  Vec3<double> x[4];  // in units of the edge, whose square any number type holds

  explicit UnitHinge(const Vec3<double> (&corners)[4])
      : edge(std::hypot(corners[1].x - corners[0].x, corners[1].y - corners[0].y,
                        corners[1].z - corners[0].z)) {
    for (int k = 0; k < 4; ++k) {
      x[k] = (1 / edge) * (corners[k] - corners[0]);
    }
  }
};

}  // namespace

SheetHinge SheetHinge::at_rest(const Vec3<double> (&x)[4], double stiffness) {
  const UnitHinge unit(x);
  const double angle = 4 * std::atan(BendingConstraint::value(unit.x, 0.0) / 4);
  const double cosine = std::cos(angle);
  const double sine = std::abs(std::sin(angle)) < kFlat ? 0 : std::sin(angle);
  double p[4] = {}, q[4] = {};  // what vertices count in P and in Q
  double volume = 1;            // L height height', in units of the edge
  const auto weigh = [&](int opposite, double(&shares)[4]) {
    const Vec3<double> normal = cross(unit.x[1], unit.x[opposite]);
    const double height = std::sqrt(dot(normal, normal));
    const double foot = dot(unit.x[opposite], unit.x[1]);
    shares[0] = (foot - 1) / height;
    shares[1] = -foot / height;
    shares[opposite] = 1 / height;
    volume *= height;
  };
  weigh(2, p);
  weigh(3, q);
  const double along[4] = {-1, 1, 0, 0};
  const double square = unit.edge * unit.edge;
  SheetHinge hinge{};
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto [i, j] = kTetEdges[e];
    hinge.weights[e] = -stiffness / square *
                       (p[i] * p[j] + q[i] * q[j] + cosine * (p[i] * q[j] + q[i] * p[j]) +
                        sine * sine * along[i] * along[j]);
  }
  hinge.moment = stiffness * sine / (square * unit.edge * volume);
  return hinge;
}

HingeAtRest hinge_at_rest(const Vec3<double> (&x)[4], double rigidity) {
  check_positive("the flexural rigidity of a hinge", rigidity, " N m");
  const double stiffness = rigidity * checked_hinge_shape(x, "a hinge", {0, 1, 2, 3});
  check_positive("the stiffness of a hinge", stiffness, " N m");
  return {BendingConstraint::value(UnitHinge(x).x, 0.0), stiffness};
}

double flexural_rigidity(double youngs_modulus, double thickness, double poissons_ratio) {
  check_positive("Young's modulus", youngs_modulus, " Pa");
  check_positive("the thickness of a plate", thickness, " m");
  check(poissons_ratio > -1 && poissons_ratio <= 0.5, "Poisson's ratio", poissons_ratio,
        "in (-1, 0.5]");
  return plate_rigidity(youngs_modulus, thickness, poissons_ratio);
}

}  // namespace pbdsurg
