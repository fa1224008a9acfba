// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/pushed_pieces.h"

#include <algorithm>
#include <numeric>

#include "lib/solver/methods/free_pieces.h"

namespace pbdsurg {

void PushedPieces::fit(const PieceLists& pieces, std::size_t place_count) {
  piece_of_.resize(place_count);
  pieces.find_pieces(piece_of_);
  groups_.resize(static_cast<std::size_t>(pieces.count()));
  is_anchored_.resize(groups_.size());
}

void PushedPieces::begin() {
  std::iota(groups_.begin(), groups_.end(), 0);
  std::ranges::fill(is_anchored_, std::uint8_t{0});
}

void PushedPieces::begin_as(const PushedPieces& other) {
  groups_ = other.groups_;
  is_anchored_ = other.is_anchored_;
}

void PushedPieces::anchor(Index place) {
  if (const Index group = group_at(place); group != kInvalidIndex) {
    is_anchored_[group] = 1;
  }
}

void PushedPieces::join(Index first, Index second) {
  const Index a = group_at(first), b = group_at(second);
  if (a == kInvalidIndex || b == kInvalidIndex) {
    anchor(first);
    anchor(second);
  } else if (a != b) {
    is_anchored_[std::min(a, b)] |= is_anchored_[std::max(a, b)];
    std::ranges::replace(groups_, std::max(a, b), std::min(a, b));
  }
}

std::size_t PushedPieces::memory_bytes() const noexcept {
  return (piece_of_.capacity() + groups_.capacity()) * sizeof(Index) + is_anchored_.capacity();
}

}  // namespace pbdsurg
