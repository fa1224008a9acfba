// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Segments, on a CPU or a device.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// Where two segments are nearest to each other, as shares of their ways from first to last.
struct SegmentPair {
  float first, second;
};

/// Of segments from a to b and from c to d (Ericson, "Real-Time Collision Detection", 2005, section
/// 5.1.9). Of parallel ones, one of the pairs.
PBDSURG_HOST_DEVICE inline SegmentPair closest_of_segments(const Vec3<float>& a,
                                                           const Vec3<float>& b,
                                                           const Vec3<float>& c,
                                                           const Vec3<float>& d) {
  const auto clamped = [](float share) { return share < 0 ? 0.0F : (share > 1 ? 1.0F : share); };
  const Vec3<float> first = b - a, second = d - c, between = a - c;
  const float first_square = dot(first, first), second_square = dot(second, second);
  const float along_second = dot(second, between);
  if (!(first_square > 0)) {
    return {0, second_square > 0 ? clamped(along_second / second_square) : 0.0F};
  }
  const float along_first = dot(first, between);
  if (!(second_square > 0)) {
    return {clamped(-along_first / first_square), 0};
  }
  const float both = dot(first, second);
  const float determinant = first_square * second_square - both * both;
  const float share =
      determinant > 0 ? clamped((both * along_second - along_first * second_square) / determinant)
                      : 0.0F;
  const float other = (both * share + along_second) / second_square;
  if (other < 0) {
    return {clamped(-along_first / first_square), 0};
  }
  if (other > 1) {
    return {clamped((both - along_first) / first_square), 1};
  }
  return {share, other};
}

}  // namespace pbdsurg
