// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Fewer colours for a colouring that there is.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// With whom a constraint that finds no colour may swap.
enum class RepairSwaps : std::uint8_t {
  with_one,  ///< with the only one that holds a colour around it
  /// Where that is stuck, also with one of two that hold a colour, while the other moves to one
  /// that is free for it. Mostly fewer colours where with_one ends above the clique bound, and the
  /// same colouring where it does not.
  with_two,
};

/// Moves constraints out of the highest colours, down to the clique bound where it can.
///
/// One-step ejection: a constraint takes a colour from the one or two that hold it around its
/// vertices, and each of those moves to another colour that is free for it. All constraints above
/// the limit try at once; of attempts that touch a common vertex the one of largest random rank
/// goes through. A constraint that finds no such way swaps with one that holds a colour, which then
/// tries in its place. Colours are emptied from the highest down, several at once while they hold
/// few; where a level cannot be emptied, what is left takes as many colours as it needs.
///
/// The colouring stays valid and never gains a colour. The result depends on the arguments other
/// than the executor alone. Cost: O(vertices named), and O(colours) for each constraint in the way
/// and round: 30 ms for a million irregular tetrahedra, a second for a lattice, and up to twice
/// that for RepairSwaps::with_two. Memory: 4 bytes and a bit a vertex and colour, unless that is
/// far more than the constraints themselves.
/// @param coloring  valid; overflow stays where it is
/// @param executor  whose threads work, if it names how many
/// @throws InvalidArgument  as find_conflict() and check_constraints(), if the colouring is not
///                          valid; then nothing has changed
PBDSURG_API void repair_coloring(Coloring& coloring, const ConstraintVertices& constraints,
                                 std::uint64_t seed = 0, const Executor& executor = {},
                                 RepairSwaps swaps = RepairSwaps::with_one);

/// Keeps the largest max_colors colours, as colours 0, 1, ... by falling size, moves into them what
/// one-step ejection can, and leaves the rest to the overflow group. Nothing changes if there are
/// no more colours than that.
/// @param max_colors  >= 1
/// @throws InvalidArgument  as repair_coloring(), or if max_colors is out of range
PBDSURG_API void limit_colors(Coloring& coloring, const ConstraintVertices& constraints,
                              Index max_colors, std::uint64_t seed = 0,
                              const Executor& executor = {});

}  // namespace pbdsurg
