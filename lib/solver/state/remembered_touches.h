// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What bodies remember of contacts with each other, by vertices.

#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Of a copy. Cost: O(vertices), if there are any.
[[nodiscard]] std::vector<SnapshotBodyContact> touches_of(const SolverState& state,
                                                          const CopyState& copy);

/// @throws InvalidArgument  naming the contact whose vertex or body there is not, whose normal is
/// no
///                          unit, whose force is not finite, or whose vertex has another with that
///                          body
void check_touches(std::span<const SnapshotBodyContact> contacts, std::size_t vertex_count,
                   std::size_t body_count);

/// Makes a copy remember these alone.
void set_touches(std::span<const SnapshotBodyContact> contacts, const SolverState& state,
                 CopyState& copy);

}  // namespace pbdsurg
