// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How one kernel for all sweeps shares vertices out to threads: some neighbouring threads of a
/// warp have a vertex, and a warp has a tile of such vertices. What a tile reads lies thread by
/// thread, so that a warp loads a row of it at once, and every thread of it has as many rows.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "lib/device/device_arrays.h"
#include "lib/device/neighbor_lists.h"
#include "lib/device/stages.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/state/changes.h"

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
///
/// A block has room for as many records as it has room for rows (VertexBlocks::BlockRoom), and
/// keeps them where it gets another index. Where neighbours outgrow their room, these go behind all
/// others; what they leave is lost until all is laid out anew.
class VertexTiles {
 public:
  VertexTiles() = default;

  /// Cost: proportional to the rows.
  /// @param parts_of_vertex  a divisor of kTileThreads
  VertexTiles(const VertexBlocks& vertices, const NeighborLists& lists, Index parts_of_vertex);

  /// Lists what to write so that neighbours and tiles are those of now. Cost: proportional to the
  /// rows of vertices that changes name, and to the blocks.
  /// @param words  appended to
  /// @return       false if this follows no more: some vertex has more neighbours than there may be
  [[nodiscard]] bool follow(const VertexBlocks& vertices, const Changes& changes,
                            std::vector<WordChange>& words);

  /// Blocks whose rows must be packed anew after what was followed since this was called last.
  [[nodiscard]] std::vector<Index> take_unpacked();

  Index parts = 1;                ///< threads of a vertex
  std::vector<TileBlock> blocks;  ///< [block]
  /// [row][thread] first the vertex itself, then neighbours: as laid out, before anything was
  /// followed. Who has taken them may clear this.
  std::vector<Neighbor> neighbors;
  Index neighbor_rows = 0, pull_rows = 0, spring_rows = 0, volume_rows = 0;
  Index most_neighbors = 0;  ///< of a thread, now or before
  Index most_blocks = 0;     ///< now or before: words may be of those that an undo has taken back

 private:
  // Of a room of VertexBlocks.
  struct Room {
    TileBlock tile{kInvalidIndex, 0, 0, 0, {}};
    Index most_neighbors = 0;  // of a thread, that there is room for
    Index block = kInvalidIndex;
    Index lane_count = 0;
    ParticleOffset last_corner = 0;
    std::array<std::uint8_t, kBlockLanes> neighbor_counts{};  // of lanes in use
  };
  using DirtyLanes = std::pair<Index, LaneBits>;  // of a block

  void lay_out(const VertexBlocks& vertices, Index block, Room& room);
  void place_neighbors(Room& room, Index count);
  [[nodiscard]] std::vector<DirtyLanes> find_dirty(const VertexBlocks& vertices,
                                                   const Changes& changes);
  [[nodiscard]] bool follow_block(const VertexBlocks& vertices, Index block, LaneBits lanes,
                                  std::vector<WordChange>& words);
  [[nodiscard]] bool find_lists(const VertexBlocks& vertices, LaneBits lanes, Room& room);
  void write_block(Index block, std::vector<WordChange>& words) const;
  template <class Write>
  void write_lane(const VertexBlock& block, Index lane, const TileCounts& counts,
                  const std::vector<Neighbor>& list, const Write& write) const;

  std::vector<Room> rooms_;      // [room]
  std::vector<Index> colors_;    // [place] of vertices, as neighbours know them
  std::vector<Index> unpacked_;  // rooms
  std::array<std::vector<Neighbor>, kBlockLanes> lists_;  // of the block at hand
};

}  // namespace pbdsurg::cuda
