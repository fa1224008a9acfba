// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How stiffly vertex blocks meet the capsules of tools.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/free_pieces.h"

namespace pbdsurg {

/// kHeldFirmness or kPlainFirmness of capsules at each place; half spaces are met with the latter.
class ContactFirmness {
 public:
  /// Finds them, if an edit came since they were. Cost then: O(vertices).
  /// @param pieces  free ones, as of now
  void refresh(const Tissue& tissue, const PieceLists& pieces,
               std::span<const Index> place_of_vertex);

  [[nodiscard]] float at(Index place) const noexcept { return of_places_[place]; }
  [[nodiscard]] std::span<const float> of_places() const noexcept { return of_places_; }

  /// Of these: another number, others.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return of_places_.capacity() * sizeof(float);
  }

 private:
  std::optional<std::uint64_t> version_;  // of the tissue that they are of
  std::uint64_t revision_ = 0;
  std::vector<float> of_places_;
};

}  // namespace pbdsurg
