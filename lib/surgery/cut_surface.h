// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which side of a cut a point lies on.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/surgery/cut.h"

namespace pbdsurg {

/// Of length one, or zero for a triangle without area to speak of.
[[nodiscard]] Eigen::Vector3d unit_normal(const CutSurface& surface, const Triangle& triangle);

/// A cut's surface, continued beyond its rim by the planes of its outermost triangles.
class CutSides {
 public:
  /// @throws InvalidArgument  see plan_cut()
  explicit CutSides(const CutSurface& surface);

  /// A point as its nearest point on the surface sees it.
  struct Place {
    double height;  ///< m, above the surface if positive, below if negative
    double beyond;  ///< m along the surface from its rim, 0 where the nearest is not on the rim
  };

  /// Cost: O(triangles).
  [[nodiscard]] Place locate(const Eigen::Vector3d& point) const;

  /// Box around the surface, m.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const noexcept { return bounds_; }

 private:
  /// A corner, an edge or the inside of a triangle.
  struct Feature {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    bool is_rim = false;
  };
  /// A triangle and its seven features, by TrianglePoint::corners.
  struct Facet {
    std::array<Eigen::Vector3d, 3> corners;
    std::array<Feature, 8> features;
  };

  Eigen::AlignedBox3d bounds_;
  std::vector<Facet> facets_;
};

}  // namespace pbdsurg
