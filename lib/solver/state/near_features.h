// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a copy keeps from substep to substep of what tools may touch soon: see near_search.h.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/state/tissue_surface.h"

namespace pbdsurg {

/// Of one tool.
struct NearFeatures {
  std::vector<PlacedCapsule> capsules;  ///< where they were when features were listed
  std::vector<Index> vertices;          ///< places, ascending
  std::vector<TissueSurface::PlaceTriangle> triangles;  ///< in their order
};

/// Of all tools, listed at one time.
struct NearLists {
  float slack = 0;                     ///< m, that anything may move; zero while there are no lists
  std::uint64_t surface_revision = 0;  ///< of the triangles
  std::vector<Vec3<float>> positions;  ///< [place] m, then
  std::vector<NearFeatures> tools;     ///< [tool] of those that meet surfaces

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t bytes = positions.capacity() * sizeof(positions[0]);
    for (const NearFeatures& tool : tools) {
      bytes += sizeof(tool) + tool.capsules.capacity() * sizeof(tool.capsules[0]) +
               tool.vertices.capacity() * sizeof(tool.vertices[0]) +
               tool.triangles.capacity() * sizeof(tool.triangles[0]);
    }
    return bytes;
  }
};

}  // namespace pbdsurg
