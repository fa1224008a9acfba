// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Points and segments.

#include <Eigen/Core>
#include <algorithm>

namespace pbdsurg {

/// The point of the segment from a to b that is nearest to x.
inline Eigen::Vector3f closest_on_segment(const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                          const Eigen::Vector3f& x) {
  const Eigen::Vector3f d = b - a;
  const float length_squared = d.squaredNorm();
  if (!(length_squared > 0)) {
    return a;
  }
  return a + std::clamp((x - a).dot(d) / length_squared, 0.0F, 1.0F) * d;
}

}  // namespace pbdsurg
