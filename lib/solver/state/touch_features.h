// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What vertices and edges of a body meet on others, on a CPU or a device.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// The point of a triangle, or of a link, that is nearest to a vertex.
struct NearPoint {
  Index corners[3];
  float weights[3];
  Vec3<float> away;  ///< m, to the vertex
  float distance;    ///< m
  // where face() was called, see touch_meeting.h
  Vec3<float> outwards;  ///< unit, out of the triangle; of a link, to the vertex
  float alignment;       ///< of the way to the vertex with that

  /// A corner of the triangle.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool is_corner() const {
    return (weights[0] == 0) + (weights[1] == 0) + (weights[2] == 0) == 2;
  }
  /// On its border.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool is_edge() const {
    return weights[0] == 0 || weights[1] == 0 || weights[2] == 0;
  }
};

/// An edge of a surface, or a link of particles: see ContactBodies::Edge.
struct CrossingEdge {
  Index ends[2];      ///< ascending
  Index opposite[2];  ///< corners of the triangles there, or kInvalidIndex
  Index body;         ///< of the tissue
  bool is_two_sided;  ///< whether that has no inside
};

}  // namespace pbdsurg
