// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bodies that meet each other, as a device searches them: see TouchArrays.

#include <vector>

#include "lib/device/device_arrays.h"
#include "lib/solver/state/contact_bodies.h"

namespace pbdsurg::cuda {

struct TouchLists {
  /// Cost: O(n log n) of vertices, triangles and edges. Lists whose lengths edits change have room
  /// for a power of two.
  explicit TouchLists(const ContactBodies& bodies);

  std::vector<TouchVertex> vertices;
  std::vector<TouchBody> bodies;
  std::vector<TouchPair> pairs;
  std::vector<TouchTriangle> triangles;  ///< whole groups
  std::vector<CrossingEdge> edges;
  std::vector<Index> edge_bodies;
  std::vector<Index> edge_groups;  ///< whole groups
  float thickest = 0;              ///< m
};

}  // namespace pbdsurg::cuda
