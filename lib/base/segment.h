// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Points and segments, on a CPU or a device.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// The point of the segment from a to b that is nearest to x.
PBDSURG_HOST_DEVICE inline Vec3<float> closest_on_segment(const Vec3<float>& a,
                                                          const Vec3<float>& b,
                                                          const Vec3<float>& x) {
  const Vec3<float> d = b - a;
  const float length_squared = dot(d, d);
  if (!(length_squared > 0)) {
    return a;
  }
  const float share = dot(x - a, d) / length_squared;
  return a + (share < 0 ? 0.0F : (share > 1 ? 1.0F : share)) * d;
}

}  // namespace pbdsurg
