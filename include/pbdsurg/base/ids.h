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
  Index value = kInvalidIndex;  ///< kInvalidIndex: of nothing

  constexpr Id() = default;
  /// Of that number, whatever it is.
  constexpr explicit Id(Index index) noexcept : value(index) {}

  /// The number, for functions that take an Index.
  constexpr operator Index() const noexcept { return value; }
  /// Whether it is of something; only its owner knows whether that is there.
  [[nodiscard]] constexpr bool is_valid() const noexcept { return value != kInvalidIndex; }

  /// Whether both have the same number.
  friend constexpr bool operator==(Id, Id) = default;
};

using BodyId = Id<struct BodyOfScene>;   ///< of a World it stays; of a tissue, until a compaction
using ToolId = Id<struct ToolOfSolver>;  ///< of a Solver, and of its World
using CauteryId = Id<struct CauteryOfWorld>;   ///< of a World
using ReplicaId = Id<struct ReplicaOfSolver>;  ///< of a World, in [0, SolverOptions::copies)

}  // namespace pbdsurg
