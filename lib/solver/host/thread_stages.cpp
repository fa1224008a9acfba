// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/thread_stages.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace pbdsurg {

void ThreadStages::plan(const SolverData& data, int threads) {
  threads_ = threads;
  stages_.clear();
  // any of the phases may come with an edit
  const std::size_t stages_of_phase = data.options.composition == PlanComposition::joint ? 7 : 1;
  stages_.reserve(stages_of_phase * data.plan.phases.capacity());
  for (const Phase& phase : data.plan.phases) {
    switch (phase.kind) {
      case PhaseKind::distance:
      case PhaseKind::volume:
      case PhaseKind::neo_hookean:
      case PhaseKind::fibre:
      case PhaseKind::membrane:
      case PhaseKind::strain_limit:
      case PhaseKind::bending:
      case PhaseKind::stiff_link:
        data.sets.visit_set(phase.kind,
                            [&](const auto& slots) { add(data, phase, slots, phase.color); });
        break;
      case PhaseKind::joint:
        if (phase.serial) {
          add(phase, phase.color, 0);
          break;
        }
        for (Index place = 0; place < 6; ++place) {
          add(data, {PhaseKind::distance, phase.color}, data.sets.of<DistanceConstraint>(),
              data.sets.joint_group(phase.color, place));
        }
        add(data, {PhaseKind::volume, phase.color}, data.sets.of<VolumeConstraint>(), phase.color);
        break;
      case PhaseKind::vertex:  // a block takes several times as long as a meeting
        add(phase, phase.color, data.vertex_blocks.blocks(phase.color).count > 1 ? kEverybody : 0);
        break;
      case PhaseKind::attachment:
      case PhaseKind::grip:
      case PhaseKind::contact:
      case PhaseKind::body_contact:
      case PhaseKind::custom:
        add(phase, phase.color, 0);
        break;
    }
  }
}

template <class Constraint>
void ThreadStages::add(const SolverData& data, const Phase& phase,
                       const ConstraintSlots<Constraint>& slots, Index group) {
  const Index domains = data.sets.domain_counts[phase.level];
  if (domains > 1) {
    const auto owner =
        static_cast<int>(std::min<Index>(domains, threads_) * phase.domain / domains);
    const bool follows_level = !stages_.empty() && stages_.back().phase.level == phase.level &&
                               stages_.back().phase.kind != PhaseKind::vertex;
    stages_.push_back({phase, group, owner, !follows_level});
    return;
  }
  // in the time that sixteen distances take, some 20 ns
  constexpr Index kBlockCost = std::is_same_v<Constraint, NeoHookeanConstraint> ? 6
                               : std::is_same_v<Constraint, BendingConstraint>  ? 5
                               : std::is_same_v<Constraint, StiffLinkConstraint> ||
                                       std::is_same_v<Constraint, MembraneConstraint>
                                   ? 4
                                   : Constraint::kVertexCount / 2;
  constexpr Index kMeetingCost = 8;
  const Index saved =
      kBlockCost * static_cast<Index>(slots.blocks(group).size()) * (threads_ - 1) / threads_;
  add(phase, group, !phase.serial && saved > kMeetingCost ? kEverybody : 0);
}

void ThreadStages::add(const Phase& phase, Index group, int owner) {
  const bool follows_own = !stages_.empty() && stages_.back().owner == owner && owner != kEverybody;
  // in the next sweep, what comes first follows what came last
  stages_.push_back({phase, group, owner, !follows_own});
}

}  // namespace pbdsurg
