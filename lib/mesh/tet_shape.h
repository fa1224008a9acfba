// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Dihedral angles of tetrahedra, as the tetrahedraliser needs them.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/quality.h"

namespace pbdsurg {

/// Normals of the four faces with twice their area as length, outwards; face i is opposite to i.
inline std::array<Eigen::Vector3d, 4> face_normals(const std::array<Eigen::Vector3d, 4>& x) {
  const Eigen::Vector3d a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const std::array<Eigen::Vector3d, 3> n{c.cross(b), a.cross(c), b.cross(a)};
  return {-(n[0] + n[1] + n[2]), n[0], n[1], n[2]};
}

/// The smallest squared sine of the six dihedral angles: the sine vanishes for angles near 0 and
/// near 180 degrees alike. Negative unless the volume is positive.
///
/// With D six times the volume and n_k the normals above, sin = D l / (|n_k| |n_m|) on the edge of
/// length l between the faces k and m.
inline double min_squared_sine(const std::array<Eigen::Vector3d, 4>& x) {
  const std::array<Eigen::Vector3d, 4> n = face_normals(x);
  const double volume6 = -n[3].dot(x[3] - x[0]);
  if (!(volume6 > 0)) {
    return -1;
  }
  const std::array<double, 4> inverse{1 / n[0].squaredNorm(), 1 / n[1].squaredNorm(),
                                      1 / n[2].squaredNorm(), 1 / n[3].squaredNorm()};
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      // faces i and j meet in the edge between the other two vertices
      const int k = i == 0 ? (j == 1 ? 2 : 1) : 0;
      const int m = 6 - i - j - k;
      smallest = std::min(smallest, (x[k] - x[m]).squaredNorm() * inverse[i] * inverse[j]);
    }
  }
  return volume6 * volume6 * smallest;
}

/// Smallest and largest dihedral angle, rad.
struct DihedralRange {
  double min = std::numeric_limits<double>::infinity();
  double max = 0;
};

inline DihedralRange dihedral_range(std::span<const Eigen::Vector3d> points,
                                    std::span<const Tet> tets) {
  DihedralRange range;
  for (const Tet& tet : tets) {
    for (const double angle : dihedral_angles(points, tet)) {
      range.min = std::min(range.min, angle);
      range.max = std::max(range.max, angle);
    }
  }
  return range;
}

}  // namespace pbdsurg
