// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_tiles.h"

#include <algorithm>
#include <cstddef>

namespace pbdsurg::cuda {

VertexTiles::VertexTiles(const VertexBlocks& vertices, const NeighborLists& lists,
                         Index parts_of_vertex)
    : parts(parts_of_vertex) {
  const VertexBlocks::Arrays rows = vertices.arrays();
  const Index tiles = tiles_of_block(parts);
  Index neighbor_rows = 0;
  for (std::size_t b = 0; b < rows.blocks.size(); ++b) {
    const VertexBlock& from = rows.blocks[b];
    const RowRange& list = lists.ranges[b];
    TileBlock block{neighbor_rows, pull_rows, spring_rows, volume_rows, {}};
    block.counts = tile_counts(from, list.count, parts);
    neighbor_rows += tiles * (1 + block.counts.neighbors);
    pull_rows += tiles * block.counts.pulls;
    spring_rows += tiles * block.counts.springs;
    volume_rows += tiles * block.counts.volumes;
    most_neighbors = std::max<Index>(most_neighbors, block.counts.neighbors);
    blocks.push_back(block);

    const std::size_t first = neighbors.size();
    neighbors.resize(static_cast<std::size_t>(neighbor_rows) * kTileThreads);
    for (Index lane = 0; lane < kBlockLanes; ++lane) {
      const bool is_idle = lane >= from.lane_count;
      for (Index part = 0; part < parts; ++part) {
        const Index thread = lane * parts + part;  // of the block
        const auto entry = [&](Index row) -> Neighbor& {
          return neighbors[first + static_cast<std::size_t>(row * tiles * kTileThreads + thread)];
        };
        const Neighbor own = from.corners[lane] | kStandsStill;
        entry(0) = is_idle ? own | kIsIdle : own;
        for (Index k = 0; k < block.counts.neighbors; ++k) {
          const Index i = k * parts + part;
          entry(1 + k) = !is_idle && i < list.count
                             ? lists.neighbors[static_cast<std::size_t>(list.first) * kBlockLanes +
                                               static_cast<std::size_t>(lane * list.count + i)]
                             : own;
        }
      }
    }
  }
}

}  // namespace pbdsurg::cuda
