// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold with a limit, see grip.h: what a host and a device do alike.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/vertex_moves.h"

namespace pbdsurg {

/// Where a tool is in a substep.
struct GripPose {
  Vec3<float> rows[3];  ///< of the rotation from its frame
  Vec3<float> origin;   ///< m
  Vec3<float> normal;   ///< of the pad, in the scene

  /// m, in the scene.
  /// @param anchor  m, in the frame
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> place(const Vec3<float>& anchor) const {
    return Vec3<float>{dot(rows[0], anchor), dot(rows[1], anchor), dot(rows[2], anchor)} + origin;
  }
  /// A way in the scene, as the frame has it.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> in_frame(const Vec3<float>& way) const {
    return way.x * rows[0] + way.y * rows[1] + way.z * rows[2];
  }
};

/// The part of a vector along a pad.
PBDSURG_HOST_DEVICE inline Vec3<float> along_pad(const Vec3<float>& normal, const Vec3<float>& v) {
  return v - dot(normal, v) * normal;
}

PBDSURG_HOST_DEVICE inline float length_of(const Vec3<float>& v) {
  using std::sqrt;
  return sqrt(dot(v, v));
}

/// By how much of it a vector is longer than a limit.
PBDSURG_HOST_DEVICE inline float excess_of(float size, float limit) {
  return size > limit ? 1 - limit / size : 0.0F;
}

/// How far anchors slide in vertex blocks, m.
/// @param mean   m, of the ways from points to anchors along the pad, as if nothing slid
/// @param reach  m, of that at the limit
PBDSURG_HOST_DEVICE inline Vec3<float> slide_within(const Vec3<float>& mean, float reach) {
  return -excess_of(length_of(mean), reach) * mean;
}

/// What draws a point in a sweep of projections, kg m.
/// @param way     m, to where jaws want it
/// @param before  kg m, what has drawn it
/// @param yield   1/kg, sum(weights^2 * inverse masses) + alpha
/// @param alpha   1/kg, compliance over the square of the substep
PBDSURG_HOST_DEVICE inline Vec3<float> draw_of(const Vec3<float>& way, const Vec3<float>& before,
                                               float yield, float alpha) {
  return (1 / yield) * (way - alpha * before);
}

/// How far anchors slide after that.
struct GripSlide {
  Vec3<float> slide;  ///< m
  Vec3<float> way;    ///< m, from how far they had slid; nothing where it is not finite

  /// @param pull       kg m, of all points along the pad
  /// @param slid       m, so far
  /// @param stiffness  kg, of all points to anchors that slide: sum(1 / yield)
  /// @param limit      kg m
  PBDSURG_HOST_DEVICE GripSlide(const Vec3<float>& pull, const Vec3<float>& slid, float stiffness,
                                float limit) {
    const Vec3<float> trial = pull - stiffness * slid;
    slide = (-excess_of(length_of(trial), limit) / stiffness) * trial;
    way = slide - slid;
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool moves() const {
    return is_finite_way(way) && dot(way, way) > 0;
  }
};

}  // namespace pbdsurg
