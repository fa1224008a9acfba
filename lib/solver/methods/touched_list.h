// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that surfaces of tools and other bodies touch, and nothing else holds. Those that
/// touch each other are a group.

#include <cstddef>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/momentum.h"

namespace pbdsurg {

struct TouchedPiece {
  Index piece;        ///< of FreePieces
  MomentumSums sums;  ///< has mass
  Index group;        ///< the first of it in the list
  Index rank = 0;     ///< in its group
};

/// Of one worker.
class TouchedPieces {
 public:
  /// @param piece_count  of FreePieces
  void begin(Index piece_count);

  /// Adds a piece, in ascending order of these, as a group of its own.
  void add(Index piece, const MomentumSums& sums);

  /// Makes one group of those of two pieces of the list, if it has no more than a group may have.
  /// Cost: O(n) of the list, where it is their first.
  void join(Index first, Index second);

  /// Once all are joined: ranks pieces in their groups, in ascending order.
  void rank();

  [[nodiscard]] Index count() const noexcept { return static_cast<Index>(pieces_.size()); }
  [[nodiscard]] const TouchedPiece& operator[](Index i) const { return pieces_[i]; }

  /// Where a piece is in the list, or kInvalidIndex.
  [[nodiscard]] Index find(Index piece) const { return index_of_[piece]; }

  /// Pieces of a group.
  [[nodiscard]] Index size_of(Index group) const;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  std::vector<TouchedPiece> pieces_;
  std::vector<Index> index_of_;  // [piece]
};

}  // namespace pbdsurg
