// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissue that nothing holds, whose momentum sweeps of vertex blocks must keep: see momentum.h.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// Vertices of pieces, by their places.
class PieceLists {
 public:
  [[nodiscard]] Index count() const noexcept { return static_cast<Index>(firsts_.size()) - 1; }

  /// Places of a piece's vertices, ascending; pieces go in the order of their first ones.
  [[nodiscard]] std::span<const Index> places(Index piece) const noexcept {
    return {places_.data() + firsts_[piece], places_.data() + firsts_[piece + 1]};
  }

  /// The piece at each place, or kInvalidIndex.
  /// @param piece_of  [place] out
  void find_pieces(std::span<Index> piece_of) const {
    std::ranges::fill(piece_of, kInvalidIndex);
    for (Index piece = 0; piece < count(); ++piece) {
      for (const Index place : places(piece)) {
        piece_of[place] = piece;
      }
    }
  }

  /// All of them, for those who keep a copy: piece i has [firsts[i], firsts[i + 1]).
  [[nodiscard]] std::span<const Index> all_firsts() const noexcept { return firsts_; }
  [[nodiscard]] std::span<const Index> all_places() const noexcept { return places_; }

  /// Of the lists: another number, other lists.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

 protected:
  std::uint64_t revision_ = 0;
  std::vector<Index> firsts_{0};
  std::vector<Index> places_;
};

/// The pieces of tissue without a fixed vertex. What a live link or hinge joins is one piece here,
/// and free if all of it is.
///
/// An edit costs what LivePieces say. The first step after it costs O(pieces + links + hinges),
/// and O(n log n) in the vertices and tetrahedra of free pieces; of these, all are listed anew.
class FreePieces : public PieceLists {
 public:
  /// Follows a tissue from here on, with the pieces that were known before, if any: ids may have
  /// been others. Cost: O(V + T) without these.
  void follow(const Tissue& tissue, std::unique_ptr<LivePieces> known);

  /// Follows nothing any more.
  [[nodiscard]] std::unique_ptr<LivePieces> leave() noexcept { return std::move(pieces_); }

  /// Lists them, if an edit came since they were. None while nothing is followed.
  void refresh(const Tissue& tissue, std::span<const Index> place_of_vertex);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void collect(const Tissue& tissue, std::span<const Index> place_of_vertex);

  std::unique_ptr<LivePieces> pieces_;
  std::optional<std::uint64_t> version_;  // of the tissue, that the lists are of
};

/// Takes off the displacements of a free piece what sweeps have given it of momentum, unless a tool
/// touches or holds it: see touched_pieces.h. With custom constraints or contact of bodies, of
/// those that go with it: see pushed_pieces.h.
void keep_momentum(const StepContext& step, Index piece);

}  // namespace pbdsurg
