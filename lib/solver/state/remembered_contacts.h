// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tools remember of contacts, by vertices.

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Of all tools of a copy. Cost: O(vertices), if there are any.
[[nodiscard]] std::vector<SnapshotContact> contacts_of(const SolverState& state,
                                                       const CopyState& copy);

/// What contacts of a snapshot have in common: calls refuse(why) for a normal that is no unit, or a
/// force that is not finite or pulls.
template <class Contact, class Refuse>
void check_force(const Contact& contact, const Refuse& refuse) {
  constexpr float kRounding = 1e-3F;
  if (!(std::abs(contact.normal.norm() - 1) < kRounding)) {
    refuse("has a normal of length " + std::to_string(contact.normal.norm()) +
           "; it must be a unit");
  }
  if (!(contact.force >= 0) || !std::isfinite(contact.force) || !contact.friction.allFinite()) {
    refuse("has a force of " + std::to_string(contact.force) +
           " N; it must be >= 0 and finite, and friction finite");
  }
}

/// @throws InvalidArgument  naming the contact whose tool or vertex there is not, whose vertices do
///                          not follow each other, whose normal is no unit, or whose force is not
///                          finite
void check_contacts(std::span<const SnapshotContact> contacts, std::span<const ToolState> tools,
                    std::size_t vertex_count);

/// Makes tools without contacts remember these.
void set_contacts(std::span<const SnapshotContact> contacts, const SolverState& state,
                  CopyState& copy);

}  // namespace pbdsurg
