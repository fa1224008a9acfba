// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which vertices a vertex hears from, for a kernel that sweeps all colours and whose threads wait
/// for those alone.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg::cuda {

/// A neighbour: the offset of its particle, whose low bits are free, with flags.
using Neighbor = std::uint32_t;

inline constexpr Neighbor kMovesEarlier = 1;  ///< in a sweep: its colour comes before
inline constexpr Neighbor kStandsStill = 2;   ///< no block has it
inline constexpr Neighbor kNeighborFlags = 15;

/// Those of the vertex in a lane that is in use, each once, ascending by their offsets.
void find_neighbors(const VertexBlocks& blocks, Index block, Index lane,
                    std::vector<Neighbor>& neighbors);

/// The neighbours of all vertices in blocks, each once, in no order. A list is as long as the
/// longest of its block; the vertex itself, standing still, pads it.
struct NeighborLists {
  std::vector<RowRange> ranges;     ///< [block]
  std::vector<Neighbor> neighbors;  ///< [range][lane][count of the range]
  Index longest = 0;

  NeighborLists() = default;

  /// Cost: proportional to the rows.
  explicit NeighborLists(const VertexBlocks& blocks);

  /// Of a lane in use.
  [[nodiscard]] std::span<const Neighbor> of(Index block, Index lane) const noexcept {
    const auto [first, count] = ranges[block];
    return std::span(neighbors).subspan(
        static_cast<std::size_t>(first) * kBlockLanes + static_cast<std::size_t>(lane * count),
        static_cast<std::size_t>(count));
  }
};

}  // namespace pbdsurg::cuda
