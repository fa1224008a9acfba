// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Whether a segment passes through a triangle.

#include <Eigen/Geometry>

namespace pbdsurg {

/// Six times the volume of a tetrahedron, m^3: positive where d lies on the side of a, b, c from
/// which they run clockwise.
inline double signed_volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  return (b - a).dot((c - a).cross(d - a));
}

/// Whether the segment from a to b meets the triangle p, q, r, its rim and the segment's ends
/// included, so that none slips through between two triangles. A segment in the triangle's plane,
/// and a triangle without area, meet nothing.
inline bool segment_crosses(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                            const Eigen::Vector3d& r) {
  const double side_a = signed_volume(p, q, r, a);
  const double side_b = signed_volume(p, q, r, b);
  if ((side_a > 0 && side_b > 0) || (side_a < 0 && side_b < 0) || (side_a == 0 && side_b == 0)) {
    return false;
  }
  const double pq = signed_volume(a, b, p, q);
  const double qr = signed_volume(a, b, q, r);
  const double rp = signed_volume(a, b, r, p);
  return (pq >= 0 && qr >= 0 && rp >= 0) || (pq <= 0 && qr <= 0 && rp <= 0);
}

}  // namespace pbdsurg
