// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A filled surface as a device reads it.

#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/filling_sweep.h"
#include "lib/solver/methods/filling.h"

namespace pbdsurg::cuda {

/// What FillingArrays point to, of the same names.
struct FillingLists {
  FillingLists() = default;

  /// Cost: O(triangles).
  /// @param place_of_vertex  see SolverData
  FillingLists(const Filling::Surface& surface, std::span<const Index> place_of_vertex);

  std::vector<Index> places;
  std::vector<FillingTriangle> triangles;
  std::vector<Index> firsts, triangles_at, hole_ends;
  Index wall_count = 0;
};

}  // namespace pbdsurg::cuda
