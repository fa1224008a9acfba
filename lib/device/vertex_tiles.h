// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How one kernel for all sweeps shares vertices out to threads: some neighbouring threads of a
/// warp have a vertex, and a warp has a tile of such vertices. What a tile reads lies thread by
/// thread, so that a warp loads a row of it at once, and every thread of it has as many rows.

#include <vector>

#include "lib/device/device_arrays.h"
#include "lib/device/neighbor_lists.h"
#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg::cuda {

inline constexpr Index kTileThreads = 32;

/// A thread of this has no vertex.
inline constexpr Neighbor kIsIdle = 4;

/// So many tiles has a block of vertices.
constexpr Index tiles_of_block(Index parts) noexcept {
  return kBlockLanes * parts / kTileThreads;
}

/// Where what a thread reads lies, before rows are packed. Row k of tile t of a block is row
/// first + k * tiles_of_block() + t of an array, a record for each thread.
struct VertexTiles {
  Index parts = 1;                  ///< threads of a vertex
  std::vector<TileBlock> blocks;    ///< [block]
  std::vector<Neighbor> neighbors;  ///< [row][thread] first the vertex itself, then neighbours
  Index pull_rows = 0, spring_rows = 0, volume_rows = 0;
  Index most_neighbors = 0;  ///< of a thread

  VertexTiles() = default;

  /// Cost: proportional to the rows. See NeighborLists for what edits may change.
  /// @param parts_of_vertex  a divisor of kTileThreads
  VertexTiles(const VertexBlocks& vertices, const NeighborLists& lists, Index parts_of_vertex);
};

}  // namespace pbdsurg::cuda
