// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_tiles.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace pbdsurg::cuda {
namespace {

constexpr LaneBits kAllLanes = (LaneBits{1} << kBlockLanes) - 1;

constexpr LaneBits bit_of(Index lane) noexcept {
  return LaneBits{1} << lane;
}

// Of a block whose rows fill their room, but for neighbours.
TileCounts most_counts(const VertexBlocks::BlockRoom& room, Index parts) {
  VertexBlock block{};
  block.pulls.count = room.pulls.count;
  block.springs.count = room.springs.count;
  block.volumes.count = room.volumes.count;
  return tile_counts(block, 0, parts);
}

// Those that some element joins to a vertex, or did; some more than once.
template <class Visit>
void for_each_joined(const VertexBlocks& vertices, Index vertex, const Visit& visit) {
  const auto visit_all = [&](const auto& elements, std::span<const Index> ids) {
    for (const Index id : ids) {
      for (const Index other : elements[static_cast<std::size_t>(id)].vertices) {
        visit(other);
      }
    }
  };
  visit_all(vertices.tets(), vertices.tets_at(vertex));
  visit_all(vertices.springs(), vertices.springs_at(vertex));
  visit_all(vertices.hinges(), vertices.hinges_at(vertex));
  visit_all(vertices.triangles(), vertices.triangles_at(vertex));
}

}  // namespace

VertexTiles::VertexTiles(const VertexBlocks& vertices, const NeighborLists& lists,
                         Index parts_of_vertex)
    : parts(parts_of_vertex), rooms_(static_cast<std::size_t>(vertices.room_count())) {
  const VertexBlocks::Arrays rows = vertices.arrays();
  const std::size_t stride = static_cast<std::size_t>(tiles_of_block(parts)) * kTileThreads;
  for (Index b = 0; b < vertices.block_count(); ++b) {
    const VertexBlock& from = rows.blocks[b];
    Room& room = rooms_[vertices.room_of(b).number];
    for (Index lane = 0; lane < from.lane_count; ++lane) {
      const std::span<const Neighbor> list = lists.of(b, lane);
      const auto end = std::ranges::find(list, from.corners[lane] | kStandsStill);
      lists_[lane].assign(list.begin(), end);
      room.neighbor_counts[lane] = static_cast<std::uint8_t>(end - list.begin());
    }
    lay_out(vertices, b, room);
    room.tile.counts = tile_counts(from, lists.ranges[b].count, parts);
    place_neighbors(room, room.tile.counts.neighbors);
    most_neighbors = std::max<Index>(most_neighbors, room.tile.counts.neighbors);
    blocks.push_back(room.tile);
    const std::size_t first = neighbors.size();
    neighbors.resize(static_cast<std::size_t>(neighbor_rows) * kTileThreads);
    for (Index lane = 0; lane < kBlockLanes; ++lane) {
      write_lane(from, lane, room.tile.counts, lists_[lane],
                 [&](Index row, Index thread, Neighbor neighbor) {
                   neighbors[first + static_cast<std::size_t>(row) * stride +
                             static_cast<std::size_t>(thread)] = neighbor;
                 });
    }
  }
  most_blocks = vertices.block_count();
  for (Index v = 0; v < vertices.vertex_count(); ++v) {
    colors_.push_back(vertices.color_of(v));
  }
}

// All but neighbours.
void VertexTiles::lay_out(const VertexBlocks& vertices, Index block, Room& room) {
  const VertexBlock& from = vertices.arrays().blocks[block];
  const Index tiles = tiles_of_block(parts);
  const TileCounts most = most_counts(vertices.room_of(block), parts);
  room.tile = {kInvalidIndex, pull_rows, spring_rows, volume_rows, {}};
  pull_rows += tiles * most.pulls;
  spring_rows += tiles * most.springs;
  volume_rows += tiles * most.volumes;
  room.block = block;
  room.lane_count = from.lane_count;
  room.last_corner = from.corners[kBlockLanes - 1];
}

void VertexTiles::place_neighbors(Room& room, Index count) {
  room.tile.neighbors = neighbor_rows;
  room.most_neighbors = count;
  neighbor_rows += tiles_of_block(parts) * (1 + count);
}

// Row 0 is of the vertex itself. Idle lanes have no neighbours.
template <class Write>
void VertexTiles::write_lane(const VertexBlock& block, Index lane, const TileCounts& counts,
                             const std::vector<Neighbor>& list, const Write& write) const {
  const bool is_idle = lane >= block.lane_count;
  const Neighbor own = block.corners[lane] | kStandsStill;
  for (Index part = 0; part < parts; ++part) {
    const Index thread = lane * parts + part;  // of the block
    write(0, thread, is_idle ? own | kIsIdle : own);
    for (Index k = 0; k < counts.neighbors; ++k) {
      const auto i = static_cast<std::size_t>(k * parts + part);
      write(1 + k, thread, !is_idle && i < list.size() ? list[i] : own);
    }
  }
}

bool VertexTiles::follow(const VertexBlocks& vertices, const Changes& changes,
                         std::vector<WordChange>& words) {
  blocks.resize(static_cast<std::size_t>(vertices.block_count()));
  most_blocks = std::max(most_blocks, vertices.block_count());
  rooms_.resize(static_cast<std::size_t>(vertices.room_count()));
  return std::ranges::all_of(find_dirty(vertices, changes), [&](const DirtyLanes& dirty) {
    return follow_block(vertices, dirty.first, dirty.second, words);
  });
}

// Each block once.
std::vector<VertexTiles::DirtyLanes> VertexTiles::find_dirty(const VertexBlocks& vertices,
                                                             const Changes& changes) {
  std::vector<DirtyLanes> dirty;
  const auto mark = [&](Index vertex) {
    const auto [block, lane] = vertices.place_of(vertex);
    if (block != kInvalidIndex) {
      dirty.emplace_back(block, bit_of(lane));
    }
  };
  for (const Index block : changes.blocks) {
    if (block < vertices.block_count()) {
      dirty.emplace_back(block, 0);
    }
  }
  colors_.resize(static_cast<std::size_t>(vertices.vertex_count()), kInvalidIndex);
  for (const auto& [kind, place] : changes.constraints) {
    if (kind != PhaseKind::vertex || place >= vertices.vertex_count()) {
      continue;
    }
    mark(place);
    if (colors_[place] != vertices.color_of(place)) {
      colors_[place] = vertices.color_of(place);
      for_each_joined(vertices, place, mark);
    }
  }
  std::ranges::sort(dirty);
  std::size_t count = 0;
  for (const DirtyLanes& next : dirty) {
    if (count > 0 && dirty[count - 1].first == next.first) {
      dirty[count - 1].second |= next.second;
    } else {
      dirty[count++] = next;
    }
  }
  dirty.resize(count);
  return dirty;
}

bool VertexTiles::follow_block(const VertexBlocks& vertices, Index block, LaneBits lanes,
                               std::vector<WordChange>& words) {
  const VertexBlock& from = vertices.arrays().blocks[block];
  Room& room = rooms_[vertices.room_of(block).number];
  const LaneBits idle = kAllLanes & ~(bit_of(from.lane_count) - 1);
  const bool is_new = room.tile.neighbors == kInvalidIndex;
  if (is_new) {
    lay_out(vertices, block, room);
    lanes = kAllLanes;
  } else if (room.lane_count != from.lane_count ||
             room.last_corner != from.corners[kBlockLanes - 1]) {
    lanes |= idle;
  }
  room.block = block;
  room.lane_count = from.lane_count;
  room.last_corner = from.corners[kBlockLanes - 1];
  if (!find_lists(vertices, lanes, room)) {
    return false;
  }
  const Index longest = *std::max_element(room.neighbor_counts.begin(),
                                          room.neighbor_counts.begin() + from.lane_count);
  const TileCounts before = room.tile.counts;
  room.tile.counts = tile_counts(from, longest, parts);
  const Index count = room.tile.counts.neighbors;
  most_neighbors = std::max(most_neighbors, count);
  if (is_new || count > room.most_neighbors) {
    place_neighbors(room, count);
  }
  if (count > before.neighbors && lanes != kAllLanes) {  // rows that lanes have not yet, or there
    static_cast<void>(find_lists(vertices, kAllLanes & ~lanes, room));
    lanes = kAllLanes;
  }
  blocks[block] = room.tile;
  write_block(block, words);
  const std::size_t stride = static_cast<std::size_t>(tiles_of_block(parts)) * kTileThreads;
  const std::size_t first = static_cast<std::size_t>(room.tile.neighbors) * kTileThreads;
  for (Index lane = 0; lane < kBlockLanes; ++lane) {
    if ((lanes & bit_of(lane)) != 0) {
      write_lane(from, lane, room.tile.counts, lists_[lane],
                 [&](Index row, Index thread, Neighbor neighbor) {
                   const std::size_t word = first + static_cast<std::size_t>(row) * stride +
                                            static_cast<std::size_t>(thread);
                   words.push_back(
                       {DeviceArray::tile_neighbors, static_cast<std::uint32_t>(word), neighbor});
                 });
    }
  }
  if (lanes != 0) {
    unpacked_.push_back(vertices.room_of(block).number);
  }
  return true;
}

// Of some lanes of a room's block, those in use.
bool VertexTiles::find_lists(const VertexBlocks& vertices, LaneBits lanes, Room& room) {
  for (Index lane = 0; lane < room.lane_count; ++lane) {
    if ((lanes & bit_of(lane)) == 0) {
      continue;
    }
    std::vector<Neighbor>& list = lists_[lane];
    find_neighbors(vertices, room.block, lane, list);
    if (list.size() > static_cast<std::size_t>(TileArrays::kMostNeighbors)) {
      return false;
    }
    room.neighbor_counts[lane] = static_cast<std::uint8_t>(list.size());
  }
  return true;
}

void VertexTiles::write_block(Index block, std::vector<WordChange>& words) const {
  constexpr std::size_t kWords = sizeof(TileBlock) / sizeof(std::uint32_t);
  std::array<std::uint32_t, kWords> values;
  std::memcpy(values.data(), &blocks[block], sizeof values);
  for (std::size_t w = 0; w < kWords; ++w) {
    words.push_back({DeviceArray::tile_blocks,
                     static_cast<std::uint32_t>(static_cast<std::size_t>(block) * kWords + w),
                     values[w]});
  }
}

std::vector<Index> VertexTiles::take_unpacked() {
  std::ranges::sort(unpacked_);
  unpacked_.erase(std::unique(unpacked_.begin(), unpacked_.end()), unpacked_.end());
  std::vector<Index> found;
  for (const Index number : unpacked_) {  // some may have no block any more
    const Room& room = rooms_[number];
    if (room.block < static_cast<Index>(blocks.size()) &&
        blocks[room.block].neighbors == room.tile.neighbors) {
      found.push_back(room.block);
    }
  }
  unpacked_.clear();
  return found;
}

}  // namespace pbdsurg::cuda
