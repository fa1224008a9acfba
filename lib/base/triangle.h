// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Triangles, on a CPU or a device, whatever the vectors.

#include "pbdsurg/base/host_device.h"

namespace pbdsurg {

/// What is nearest of a triangle from a to b and c: the feature, in which bit i is set for corner
/// i, and the point a + (b * (b - a) + c * (c - a)) / sum.
template <class Scalar>
struct TriangleFeature {
  unsigned corners;
  Scalar b, c, sum;
};

/// Of a point p, by the region of the triangle's plane that it projects into: Ericson 2005,
/// "Real-time collision detection", section 5.1.5.
/// @param ab_ap  (b - a) . (p - a), and so on
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr TriangleFeature<Scalar> closest_feature(Scalar ab_ap, Scalar ac_ap,
                                                                      Scalar ab_bp, Scalar ac_bp,
                                                                      Scalar ab_cp, Scalar ac_cp) {
  if (ab_ap <= 0 && ac_ap <= 0) {
    return {0b001, 0, 0, 1};
  }
  if (ab_bp >= 0 && ac_bp <= ab_bp) {
    return {0b010, 1, 0, 1};
  }
  if (ac_cp >= 0 && ab_cp <= ac_cp) {
    return {0b100, 0, 1, 1};
  }
  const Scalar c_weight = ab_ap * ac_bp - ab_bp * ac_ap;
  if (c_weight <= 0 && ab_ap >= 0 && ab_bp <= 0) {
    return {0b011, ab_ap / (ab_ap - ab_bp), 0, 1};
  }
  const Scalar b_weight = ab_cp * ac_ap - ab_ap * ac_cp;
  if (b_weight <= 0 && ac_ap >= 0 && ac_cp <= 0) {
    return {0b101, 0, ac_ap / (ac_ap - ac_cp), 1};
  }
  const Scalar a_weight = ab_bp * ac_cp - ab_cp * ac_bp;
  const Scalar along_b = ac_bp - ab_bp, along_c = ab_cp - ac_cp;
  if (a_weight <= 0 && along_b >= 0 && along_c >= 0) {
    const Scalar share = along_b / (along_b + along_c);
    return {0b110, 1 - share, share, 1};
  }
  return {0b111, b_weight, c_weight, a_weight + b_weight + c_weight};
}

}  // namespace pbdsurg
