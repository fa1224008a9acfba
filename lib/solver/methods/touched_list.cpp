// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touched_list.h"

#include <algorithm>

#include "lib/solver/methods/group_balance.h"

namespace pbdsurg {

void TouchedPieces::begin(Index piece_count) {
  pieces_.clear();
  pieces_.reserve(static_cast<std::size_t>(piece_count));
  index_of_.assign(static_cast<std::size_t>(piece_count), kInvalidIndex);
}

void TouchedPieces::add(Index piece, const MomentumSums& sums) {
  index_of_[piece] = count();
  pieces_.push_back({piece, sums, count()});
}

void TouchedPieces::join(Index first, Index second) {
  const Index a = std::min(pieces_[first].group, pieces_[second].group);
  const Index b = std::max(pieces_[first].group, pieces_[second].group);
  if (a == b || size_of(a) + size_of(b) > GroupSpace::kMostPieces) {
    return;
  }
  for (TouchedPiece& piece : pieces_) {
    piece.group = piece.group == b ? a : piece.group;
  }
}

void TouchedPieces::rank() {
  for (Index i = 0; i < count(); ++i) {
    Index rank = 0;
    for (Index j = pieces_[i].group; j < i; ++j) {
      rank += pieces_[j].group == pieces_[i].group ? 1 : 0;
    }
    pieces_[i].rank = rank;
  }
}

Index TouchedPieces::size_of(Index group) const {
  return static_cast<Index>(std::ranges::count(pieces_, group, &TouchedPiece::group));
}

std::size_t TouchedPieces::memory_bytes() const noexcept {
  return pieces_.capacity() * sizeof(TouchedPiece) + index_of_.capacity() * sizeof(Index);
}

}  // namespace pbdsurg
