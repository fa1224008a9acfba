// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/constraint_groups.h"

namespace pbdsurg {

bool takes(const Phase& phase, PhaseKind kind) noexcept {
  return !phase.serial &&
         (phase.kind == kind || (phase.kind == PhaseKind::joint && kind == PhaseKind::volume));
}

std::vector<Index> joinable_groups(const ConstraintData& data, PhaseKind kind) {
  std::vector<Index> groups;
  for (const Phase& phase : data.phases) {
    if (phase.level == data.last_level() && takes(phase, kind)) {
      groups.push_back(phase.color);
    }
  }
  return groups;
}

void close_group(ConstraintData& data, PhaseKind kind) {
  data.visit_set(kind, [&](auto& set) {
    const Index group = set.group_count() - 1;
    std::erase_if(data.phases,
                  [&](const Phase& phase) { return phase.kind == kind && phase.color == group; });
    set.close_group();
  });
}

void close_waiting_groups(ConstraintData& data) {
  data.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& set) {
    constexpr PhaseKind kKind = KindOf<Constraint>::kPhase;
    const auto is_last = [&](const Phase& phase) {
      return phase.kind == kKind && phase.color == set.group_count() - 1 && !phase.serial &&
             phase.level == data.last_level() && phase.domain == 0;
    };
    while (set.group_count() > 0 && set.size(set.group_count() - 1) == 0 &&
           std::ranges::any_of(data.phases, is_last)) {
      close_group(data, kKind);
    }
  });
}

}  // namespace pbdsurg
