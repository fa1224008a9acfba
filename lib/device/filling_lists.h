// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A filled surface as a device reads it.

#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/filling_sweep.h"
#include "lib/solver/methods/filling.h"
#include "lib/solver/methods/free_pieces.h"

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

/// What else a wall is part of, of vertex blocks: FillingArrays of the same names.
struct WallTies {
  std::vector<Index> is_shared, pieces;
  bool is_anchored = false;
};

/// Of several walls. Cost: O(vertices of walls and of free pieces).
/// @param walls  [wall] places of its vertices; those without a wall have no ties
[[nodiscard]] std::vector<WallTies> find_ties(std::span<const std::span<const Index>> walls,
                                              const PieceLists& pieces, std::size_t place_count);

}  // namespace pbdsurg::cuda
