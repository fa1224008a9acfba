// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Groups of constraints that edits add to, open and close.

#include <algorithm>
#include <tuple>
#include <vector>

#include "pbdsurg/solver/step_plan.h"

#include "lib/solver/sets/constraint_sets.h"

namespace pbdsurg {

/// Whether edits may add constraints of a kind to what a phase projects. Joint phases project
/// volumes, too: where an edge is owned, its tetrahedron has both vertices.
[[nodiscard]] bool takes(const Phase& phase, PhaseKind kind) noexcept;

/// Those that a new constraint may join, where they are free at its vertices.
[[nodiscard]] std::vector<Index> joinable_groups(const ConstraintData& data, PhaseKind kind);

/// An empty group behind the others of its kind, with a phase of its own.
template <class Constraint>
Index open_group(ConstraintData& data) {
  auto& set = data.of<Constraint>();
  set.open_group();
  const Phase phase{KindOf<Constraint>::kPhase, set.group_count() - 1, false, data.last_level(), 0};
  const auto place =
      std::ranges::upper_bound(data.phases, phase, [](const Phase& a, const Phase& b) {
        return std::tie(a.level, a.domain, a.kind, a.serial) <  // what is serial comes last
               std::tie(b.level, b.domain, b.kind, b.serial);
      });
  data.phases.insert(place, phase);
  return phase.color;
}

/// Takes back the last open_group() of a kind.
void close_group(ConstraintData& data, PhaseKind kind);

/// Closes those behind the others of their kinds that are empty, as long as open_group() would give
/// the same.
void close_waiting_groups(ConstraintData& data);

}  // namespace pbdsurg
