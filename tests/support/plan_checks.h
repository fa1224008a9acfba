// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a plan must be after any edit.

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "tests/support/inspect.h"

namespace pbdsurg::testing {

/// Whether no two constraints that are projected at a time share a vertex: two of one group, of the
/// edges and tetrahedra of one joint phase, or of different domains of a level; and whether what is
/// serial comes last of its kind, as devices have it.
inline bool is_plan_valid(const SolverData& data) {
  bool is_valid = std::ranges::is_sorted(data.sets.phases, {}, [](const Phase& phase) {
    return std::tuple(phase.level, phase.domain, phase.kind, phase.serial);
  });
  std::map<std::tuple<Index, Index>, Index> domain_of;  // level, place
  const auto visit = [&](const Phase& phase, const auto& slots, Index group,
                         std::map<Index, Index>& users, auto user_of) {
    std::set<std::pair<Index, Index>> in_group;
    for (const Index id : slots.ids(group)) {
      for (const Index place : slots.record(id).places) {
        const Index user = user_of(id);
        is_valid = is_valid && (phase.serial || users.emplace(place, user).first->second == user);
        is_valid = is_valid && (phase.serial || in_group.emplace(group, place).second);
        const auto [here, is_new] = domain_of.emplace(std::tuple(phase.level, place), phase.domain);
        is_valid = is_valid && (is_new || here->second == phase.domain);
      }
    }
  };
  const auto self = [](Index id) { return id; };
  for (const Phase& phase : data.sets.phases) {
    std::map<Index, Index> users;
    if (phase.kind == PhaseKind::joint) {
      for (Index place = 0; place < 6; ++place) {
        visit(phase, data.sets.of<DistanceConstraint>(), data.sets.joint_group(phase.color, place),
              users, [&](Index distance) {
                const Index owner = data.sets.edge_owners[data.sets.distance_ids.edge_of(distance)];
                is_valid =
                    is_valid && data.sets.of<VolumeConstraint>().group_of(owner) == phase.color;
                return owner;
              });
      }
    }
    data.sets.visit_set(phase.kind,
                        [&](const auto& slots) { visit(phase, slots, phase.color, users, self); });
  }
  return is_valid;
}

}  // namespace pbdsurg::testing
