// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The contacts of a step as programs are told of them, by vertices. Where another solver takes the
/// place of the one that stepped, as one that was compacted or loaded, it has these until its first
/// step.

#include <cstddef>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/tissue_contact.h"
#include "pbdsurg/solver/tool.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Solver::tool_contacts(). Cost: O(vertices), if there are any.
[[nodiscard]] std::vector<ToolContact> contacts_of_tool(const SolverState& state,
                                                        const CopyState& copy,
                                                        const ToolState& tool);

/// Solver::body_contacts(), of a copy whose state is current. Cost: likewise.
[[nodiscard]] std::vector<BodyContact> contacts_of_bodies(const SolverState& state,
                                                          const CopyState& copy);

/// A step begins: what was told is no more.
void forget_told(CopyState& copy) noexcept;

/// @throws InvalidArgument  naming the vertex that there is not, or the weight or force that is not
///                          finite
void check_told(const std::vector<ToolContact>& contacts, std::size_t vertex_count);
/// @throws InvalidArgument  likewise, and the body that there is not
void check_told(const std::vector<BodyContact>& contacts, std::size_t vertex_count,
                std::size_t body_count);

/// Without those of vertices and bodies that are gone.
/// @param vertices  [vertex] its id now, or kInvalidIndex
/// @param bodies    likewise
void renumber(std::vector<ToolContact>& contacts, const std::vector<Index>& vertices);
void renumber(std::vector<BodyContact>& contacts, const std::vector<Index>& vertices,
              const std::vector<Index>& bodies);

}  // namespace pbdsurg
