// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A free piece of tissue within a substep of vertex blocks, on a host.

#include <algorithm>
#include <array>
#include <cstddef>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/free_pieces.h"
#include "lib/solver/methods/momentum.h"
#include "lib/solver/methods/pushed_pieces.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Adds up sums as momentum.h says.
template <class Sums>
[[nodiscard]] Sums total(std::array<Sums, kMomentumSums>& sums) {
  for (Index half = kMomentumSums / 2; half > 0; half /= 2) {
    for (Index i = 0; i < half; ++i) {
      sums[i].add(sums[i + half]);
    }
  }
  return sums[0];
}

class MovingPiece {
 public:
  /// @param groups  all pieces that go with it move; none if others have it: see pushed_pieces.h.
  ///                Null: it moves by itself
  MovingPiece(const StepContext& step, Index piece, const PushedPieces* groups);
  /// Calls visit(place) for its vertices, piece by piece.
  template <class Visit>
  void for_each_place(const Visit& visit) const {
    const FreePieces& pieces = step_.data.free_pieces;
    const auto visit_all = [&](Index piece) { std::ranges::for_each(pieces.places(piece), visit); };
    if (groups_ == nullptr) {
      visit_all(piece_);
    } else {
      groups_->for_each_with(piece_, visit_all);
    }
  }

  /// Calls visit(hold) for what tools and other bodies do at its vertices.
  template <class Visit>
  void for_each_hold(const Visit& visit) const {
    for_each_place([&](Index place) {
      for (Index h = step_.scratch.first_holds[place]; h != kInvalidIndex;
           h = step_.scratch.holds[h].next) {
        visit(step_.scratch.holds[h]);
      }
    });
  }

  /// See keeps_momentum() and arm_of().
  [[nodiscard]] bool counts(Index place) const;
  [[nodiscard]] Vec3<double> arm(Index place) const;

  [[nodiscard]] MomentumSums momentum() const;

 private:
  const StepContext& step_;
  Index piece_;
  const PushedPieces* groups_;
  bool is_from_end_;
};

}  // namespace pbdsurg
