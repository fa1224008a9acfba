// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Numbers of things, each of a type of its own.

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// An index that is not taken for that of something else: it reads as an Index, and is made of one
/// by name alone.
template <class Thing>
struct Id {
  Index value = kInvalidIndex;

  constexpr Id() = default;
  constexpr explicit Id(Index index) noexcept : value(index) {}

  constexpr operator Index() const noexcept { return value; }
  [[nodiscard]] constexpr bool is_valid() const noexcept { return value != kInvalidIndex; }

  friend constexpr bool operator==(Id, Id) = default;
};

using BodyId = Id<struct BodyOfScene>;  ///< of a World it stays; of a tissue, until a compaction
using ToolId = Id<struct ToolOfSolver>;
using CauteryId = Id<struct CauteryOfWorld>;
using ReplicaId = Id<struct ReplicaOfSolver>;

}  // namespace pbdsurg
