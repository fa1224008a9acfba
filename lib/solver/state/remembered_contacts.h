// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tools remember of contacts, by vertices.

#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Of all tools of a copy. Cost: O(vertices), if there are any.
[[nodiscard]] std::vector<SnapshotContact> contacts_of(const SolverState& state,
                                                       const CopyState& copy);

/// @throws InvalidArgument  naming the contact whose tool or vertex there is not, whose vertices do
///                          not follow each other, whose normal is no unit, or whose force is not
///                          finite
void check_contacts(std::span<const SnapshotContact> contacts, std::span<const ToolState> tools,
                    std::size_t vertex_count);

/// Makes tools without contacts remember these.
void set_contacts(std::span<const SnapshotContact> contacts, const SolverState& state,
                  CopyState& copy);

}  // namespace pbdsurg
