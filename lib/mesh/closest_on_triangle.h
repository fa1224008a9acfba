// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The point of a triangle that is nearest to another point.

#include <Eigen/Geometry>
#include <array>

namespace pbdsurg {

/// A point of a triangle and the feature that it lies on: bit i is set for corner i, so a corner
/// has one bit, the inside of an edge two, that of the triangle three.
template <class Scalar>
struct TrianglePoint {
  Eigen::Vector3<Scalar> point;
  unsigned corners;
  std::array<Scalar, 3> weights;  ///< of the corners; their sum is one
};

/// By the region of the triangle's plane that the point projects into: Ericson 2005, "Real-time
/// collision detection", section 5.1.5.
template <class Scalar>
TrianglePoint<Scalar> closest_on_triangle(const Eigen::Vector3<Scalar>& a,
                                          const Eigen::Vector3<Scalar>& b,
                                          const Eigen::Vector3<Scalar>& c,
                                          const Eigen::Vector3<Scalar>& p) {
  using Vector = Eigen::Vector3<Scalar>;
  const Vector ab = b - a, ac = c - a;
  const Vector ap = p - a;
  const Scalar ab_ap = ab.dot(ap), ac_ap = ac.dot(ap);
  if (ab_ap <= 0 && ac_ap <= 0) {
    return {a, 0b001, {1, 0, 0}};
  }
  const Vector bp = p - b;
  const Scalar ab_bp = ab.dot(bp), ac_bp = ac.dot(bp);
  if (ab_bp >= 0 && ac_bp <= ab_bp) {
    return {b, 0b010, {0, 1, 0}};
  }
  const Vector cp = p - c;
  const Scalar ab_cp = ab.dot(cp), ac_cp = ac.dot(cp);
  if (ac_cp >= 0 && ab_cp <= ac_cp) {
    return {c, 0b100, {0, 0, 1}};
  }
  const Scalar c_weight = ab_ap * ac_bp - ab_bp * ac_ap;
  if (c_weight <= 0 && ab_ap >= 0 && ab_bp <= 0) {
    const Scalar share = ab_ap / (ab_ap - ab_bp);
    return {a + share * ab, 0b011, {1 - share, share, 0}};
  }
  const Scalar b_weight = ab_cp * ac_ap - ab_ap * ac_cp;
  if (b_weight <= 0 && ac_ap >= 0 && ac_cp <= 0) {
    const Scalar share = ac_ap / (ac_ap - ac_cp);
    return {a + share * ac, 0b101, {1 - share, 0, share}};
  }
  const Scalar a_weight = ab_bp * ac_cp - ab_cp * ac_bp;
  const Scalar along_b = ac_bp - ab_bp, along_c = ab_cp - ac_cp;
  if (a_weight <= 0 && along_b >= 0 && along_c >= 0) {
    const Scalar share = along_b / (along_b + along_c);
    return {b + share * (c - b), 0b110, {0, 1 - share, share}};
  }
  const Scalar sum = a_weight + b_weight + c_weight;
  const Scalar b_share = b_weight / sum, c_share = c_weight / sum;
  return {
      a + (b_weight * ab + c_weight * ac) / sum, 0b111, {1 - b_share - c_share, b_share, c_share}};
}

}  // namespace pbdsurg
