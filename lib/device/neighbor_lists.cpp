// SPDX-License-Identifier: Apache-2.0
#include "lib/device/neighbor_lists.h"

#include <algorithm>
#include <array>

namespace pbdsurg::cuda {
namespace {

static_assert(sizeof(Particle) > kNeighborFlags);

// Visits the neighbours that rows name, some of them more than once.
template <class Visit>
void for_each_corner(const VertexBlocks::Arrays& rows, const VertexBlock& block, Index lane,
                     const Visit& visit) {
  const auto rows_of = [](const auto& all, RowRange range) {
    return all.subspan(static_cast<std::size_t>(range.first),
                       static_cast<std::size_t>(range.count));
  };
  for (const PullRow& row : rows_of(rows.pulls, block.pulls)) {
    visit(row.neighbors[lane]);
  }
  for (const SpringRow& row : rows_of(rows.springs, block.springs)) {
    visit(row.neighbors[lane]);
  }
  for (const VolumeRow& row : rows_of(rows.volumes, block.volumes)) {
    for (const auto& corners : row.face) {
      visit(corners[lane]);
    }
  }
  for (const HingeRow& row : rows_of(rows.hinges, block.hinges)) {
    for (const auto& corners : row.neighbors) {
      visit(corners[lane]);
    }
  }
  for (const TriangleRow& row : rows_of(rows.triangles, block.triangles)) {
    for (const auto& corners : row.neighbors) {
      visit(corners[lane]);
    }
  }
  for (const FibreRow& row : rows_of(rows.fibres, block.fibres)) {
    for (const auto& corners : row.neighbors) {
      visit(corners[lane]);
    }
  }
}

}  // namespace

void find_neighbors(const VertexBlocks& blocks, Index block, Index lane,
                    std::vector<Neighbor>& neighbors) {
  const VertexBlocks::Arrays rows = blocks.arrays();
  const ParticleOffset own = rows.blocks[block].corners[lane];
  neighbors.clear();
  for_each_corner(rows, rows.blocks[block], lane, [&](ParticleOffset corner) {
    if (corner != own) {
      neighbors.push_back(corner);
    }
  });
  std::ranges::sort(neighbors);
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  const Index color = blocks.color_of(place_at(own));
  for (Neighbor& neighbor : neighbors) {
    const Index other = blocks.color_of(place_at(neighbor));
    if (other == kInvalidIndex) {
      neighbor |= kStandsStill;
    } else if (other < color) {
      neighbor |= kMovesEarlier;
    }
  }
}

NeighborLists::NeighborLists(const VertexBlocks& blocks) {
  const VertexBlocks::Arrays rows = blocks.arrays();
  ranges.resize(rows.blocks.size());
  Index first = 0;
  for (std::size_t b = 0; b < rows.blocks.size(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    std::array<std::vector<Neighbor>, kBlockLanes> lists;
    std::size_t count = 0;
    for (Index lane = 0; lane < block.lane_count; ++lane) {
      find_neighbors(blocks, static_cast<Index>(b), lane, lists[lane]);
      count = std::max(count, lists[lane].size());
    }
    ranges[b] = {first, static_cast<Index>(count)};
    first += ranges[b].count;
    longest = std::max(longest, ranges[b].count);
    for (Index lane = 0; lane < kBlockLanes; ++lane) {
      lists[lane].resize(count, block.corners[lane] | kStandsStill);
      neighbors.insert(neighbors.end(), lists[lane].begin(), lists[lane].end());
    }
  }
}

}  // namespace pbdsurg::cuda
