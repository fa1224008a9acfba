// SPDX-License-Identifier: Apache-2.0
#include "lib/device/system_plan.h"

#include <algorithm>
#include <bit>

namespace pbdsurg::cuda {
namespace {

// More blocks take longer to meet than they save.
constexpr Index kRowsPerBlock = 128;

constexpr Index kLeastRowsPerPiece = 32;
constexpr Index kWarps = kSystemThreads / 32;

Index blocks_for(Index rows, Index most) {
  const auto wanted = static_cast<std::uint32_t>(std::max(rows / kRowsPerBlock, 1));
  return std::min(static_cast<Index>(std::bit_floor(wanted)), most);
}

std::vector<Index> equal_pieces(Index rows) {
  const Index count = std::clamp(rows / kLeastRowsPerPiece, 1, kMostPieces);
  std::vector<Index> pieces;
  for (Index i = 0; i <= count; ++i) {
    pieces.push_back(static_cast<Index>(std::int64_t{rows} * i / count));
  }
  return pieces;
}

}  // namespace

SystemPlan plan_system(const SystemRows& rows, Index most_blocks, std::size_t shared_bytes) {
  SystemPlan plan;
  plan.pieces = rows.groups.empty() ? equal_pieces(rows.row_count())
                                    : std::vector<Index>(rows.groups.begin(), rows.groups.end());
  plan.block_count = std::min(blocks_for(rows.row_count(), most_blocks), plan.piece_count());
  plan.slices_per_piece = std::max(kWarps * plan.block_count / plan.piece_count(), 1);
  for (Index block = 0; block < plan.block_count; ++block) {
    const Index first = plan.pieces[plan.first_piece(block)];
    const Index end = plan.pieces[plan.first_piece(block + 1)];
    const auto entries = static_cast<std::size_t>(rows.starts[end] - rows.starts[first]);
    const std::size_t bytes =
        kRowBytes * static_cast<std::size_t>(end - first) + kEntryBytes * entries;
    plan.block_bytes = std::max(plan.block_bytes, (bytes + 15) / 16 * 16);
  }
  plan.is_in_shared_memory = plan.block_bytes <= shared_bytes;
  return plan;
}

}  // namespace pbdsurg::cuda
