// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What custom constraints and contact of bodies do to the momentum of free pieces in a substep of
/// the vertex-block method: see momentum.h. Pieces that only push each other keep theirs together.
/// What is pushed from outside has no momentum to keep: with few sweeps, a stiff push would swing
/// it the further the lighter it is.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

class PieceLists;

/// Of one worker.
class PushedPieces {
 public:
  /// Makes room. Cost: O(places).
  void fit(const PieceLists& pieces, std::size_t place_count);

  /// Each piece is by itself from here on.
  void begin();
  /// Or goes with those that it goes with elsewhere.
  void begin_as(const PushedPieces& other);

  /// Takes note of a push from outside.
  void anchor(Index place);
  /// And of one that its places have on each other. Cost: O(pieces), where it is their first.
  void join(Index first, Index second);

  /// Calls visit(piece) for those that keep their momentum with this one, ascending: it, if there
  /// are no others; none, if it was pushed from outside, or goes with an earlier one.
  template <class Visit>
  void for_each_with(Index piece, const Visit& visit) const {
    if (groups_[piece] != piece || is_anchored_[piece] != 0) {
      return;
    }
    for (auto other = piece; other < static_cast<Index>(groups_.size()); ++other) {
      if (groups_[other] == piece) {
        visit(other);
      }
    }
  }

  /// The first of the pieces that keep their momentum with the one at a place; kInvalidIndex: none.
  [[nodiscard]] Index group_at(Index place) const {
    return piece_of_[place] == kInvalidIndex ? kInvalidIndex : groups_[piece_of_[place]];
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  std::vector<Index> piece_of_;            // [place] or kInvalidIndex
  std::vector<Index> groups_;              // [piece] the first of its group
  std::vector<std::uint8_t> is_anchored_;  // [piece] of the first ones
};

}  // namespace pbdsurg
