// SPDX-License-Identifier: Apache-2.0
#include "lib/device/neighbor_lists.h"

#include <algorithm>
#include <array>

namespace pbdsurg::cuda {
namespace {

static_assert(sizeof(Particle) > kNeighborFlags);

std::vector<Index> colors_of_blocks(const VertexBlocks& blocks) {
  std::vector<Index> colors(static_cast<std::size_t>(blocks.block_count()));
  for (Index color = 0; color < blocks.color_count(); ++color) {
    const auto [first, count] = blocks.blocks(color);
    std::fill_n(colors.begin() + first, count, color);
  }
  return colors;
}

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
}

}  // namespace

NeighborLists::NeighborLists(const VertexBlocks& blocks) {
  const VertexBlocks::Arrays rows = blocks.arrays();
  const std::vector<Index> color_of = colors_of_blocks(blocks);
  ranges.resize(rows.blocks.size());
  Index first = 0;
  for (std::size_t b = 0; b < rows.blocks.size(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    std::array<std::vector<Neighbor>, kBlockLanes> lists;
    std::size_t count = 0;
    for (Index lane = 0; lane < block.lane_count; ++lane) {
      std::vector<Neighbor>& list = lists[lane];
      for_each_corner(rows, block, lane, [&](ParticleOffset corner) {
        if (corner != block.corners[lane]) {
          list.push_back(corner);
        }
      });
      std::ranges::sort(list);
      list.erase(std::ranges::unique(list).begin(), list.end());
      for (Neighbor& neighbor : list) {
        const Index other = blocks.place_of(place_at(neighbor)).block;
        if (other == kInvalidIndex) {
          neighbor |= kStandsStill;
        } else if (color_of[other] < color_of[b]) {
          neighbor |= kMovesEarlier;
        }
      }
      count = std::max(count, list.size());
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
