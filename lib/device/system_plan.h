// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How the rows of a local system are shared among the blocks of a cluster.

#include <cstddef>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/heat/system_rows.h"

namespace pbdsurg::cuda {

inline constexpr Index kMostPieces = 64;           // of a system
inline constexpr Index kSystemThreads = 512;       // of a block, eight for each piece
inline constexpr Index kMostSystemBlocks = 16;     // of a cluster
inline constexpr Index kMostSystemRows = 1 << 25;  // what columns have bits for

/// Rows are cut into pieces, the groups of the system where it has some; a block has consecutive
/// pieces. Each piece has as many slices: the warps that share it take every so many of its rows.
struct SystemPlan {
  Index block_count = 1;
  Index slices_per_piece = 1;
  std::vector<Index> pieces;         ///< [piece_count + 1] first rows
  std::size_t block_bytes = 0;       ///< what the largest block stores, a multiple of 16
  bool is_in_shared_memory = false;  ///< or in the memory of the device

  [[nodiscard]] Index piece_count() const { return static_cast<Index>(pieces.size()) - 1; }
  [[nodiscard]] Index first_piece(Index block) const { return piece_count() * block / block_count; }
};

/// Of one row and of one entry that a block stores, bytes; see BlockStore.
inline constexpr std::size_t kRowBytes = 7 * sizeof(double);
inline constexpr std::size_t kEntryBytes = sizeof(double) + sizeof(Index);

/// @param most_blocks   of a cluster on the device, >= 1
/// @param shared_bytes  that a block may store in its shared memory
[[nodiscard]] SystemPlan plan_system(const SystemRows& rows, Index most_blocks,
                                     std::size_t shared_bytes);

}  // namespace pbdsurg::cuda
