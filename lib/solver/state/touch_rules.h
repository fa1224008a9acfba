// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which vertices, triangles and edges may meet at all, on a CPU or a device.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// Links join no corner of a triangle or an edge, or of its neighbours, with such of the other; and
/// within a surface, they are no neighbours, nor near at rest.
struct TouchRules {
  const std::uint8_t* is_joined;  ///< [place] whether links end there or next to it
  const Vec3<float>* rest;        ///< [place] m
  const Index* first_neighbors;   ///< [place + 1] of surfaces that meet themselves
  const Index* neighbors;         ///< places

  /// @param corners  [3] of a triangle, or of an edge or a link with its second end twice
  /// @param near     m, at rest
  [[nodiscard]] PBDSURG_HOST_DEVICE bool may_meet(Index place, const Index* corners,
                                                  bool is_own_body, float near) const {
    if (is_joined[place] != 0 &&
        (is_joined[corners[0]] != 0 || is_joined[corners[1]] != 0 || is_joined[corners[2]] != 0)) {
      return false;
    }
    if (!is_own_body) {
      return true;
    }
    const auto is_corner = [&](Index other) {
      return other == corners[0] || other == corners[1] || other == corners[2];
    };
    if (is_corner(place)) {
      return false;
    }
    for (Index n = first_neighbors[place]; n < first_neighbors[place + 1]; ++n) {
      if (is_corner(neighbors[n])) {
        return false;
      }
    }
    for (int k = 0; k < 3; ++k) {
      const Vec3<float> d = rest[corners[k]] - rest[place];
      if (!(dot(d, d) > near * near)) {
        return false;
      }
    }
    return true;
  }

  bool operator==(const TouchRules&) const = default;
};

}  // namespace pbdsurg
