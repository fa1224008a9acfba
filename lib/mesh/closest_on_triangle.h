// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The point of a triangle that is nearest to another point.

#include <Eigen/Geometry>
#include <array>

#include "lib/base/triangle.h"

namespace pbdsurg {

/// A point of a triangle and the feature that it lies on: bit i is set for corner i, so a corner
/// has one bit, the inside of an edge two, that of the triangle three.
template <class Scalar>
struct TrianglePoint {
  Eigen::Vector3<Scalar> point;
  unsigned corners;
};

template <class Scalar>
TrianglePoint<Scalar> closest_on_triangle(const Eigen::Vector3<Scalar>& a,
                                          const Eigen::Vector3<Scalar>& b,
                                          const Eigen::Vector3<Scalar>& c,
                                          const Eigen::Vector3<Scalar>& p) {
  using Vector = Eigen::Vector3<Scalar>;
  const Vector ab = b - a, ac = c - a;
  const Vector ap = p - a, bp = p - b, cp = p - c;
  const auto [corners, b_weight, c_weight, sum] = closest_feature<Scalar>(
      ab.dot(ap), ac.dot(ap), ab.dot(bp), ac.dot(bp), ab.dot(cp), ac.dot(cp));
  switch (corners) {
    case 0b001:
      return {a, corners};
    case 0b010:
      return {b, corners};
    case 0b100:
      return {c, corners};
    case 0b110:
      return {b + c_weight * (c - b), corners};
    default:
      return {a + (b_weight * ab + c_weight * ac) / sum, corners};
  }
}

}  // namespace pbdsurg
