// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/stiff_links.h"

#include <algorithm>

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/loose_end.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

LooseEnd loose_end(const StepContext& step, const VertexState& state, ParticleOffset corner) {
  const Index v = place_at(corner);
  const auto [index, lane] = step.data.vertex_blocks.place_of(v);
  const Particle& p = at(state.displacements, corner);
  const FixedPoint& point = at(state.fixed_points, corner);
  if (is_lost(point)) {
    return {{}, {}, true};
  }
  if (index == kInvalidIndex || !(p.w > 0)) {
    return {};
  }
  const Vec3<float> u = load(p);
  const VertexRows rows = vertex_rows(step);
  VertexEnergy<float> start;
  start.add_pull(state.inverse_dt_squared / p.w, load(at(state.flights, corner)) - u);
  return loose_end(
      rows, rows.blocks[index], LaneAccess{state.fixed_points, point, lane}, start,
      HeldVertex(step, {load(at(state.bases, corner)), u}, step.scratch.first_holds[v]));
}

}  // namespace

void begin_joints(const StepContext& step, const VertexState& state, Index group, Index first,
                  Index end) {
  using Constraint = StiffLinkConstraint;
  const ConstraintSlots<Constraint>& slots = step.data.sets.of<Constraint>();
  const auto* const blocks = slots.blocks(group).data();
  const Index size = slots.size(group);
  auto* const stored = step.scratch.multipliers.of<Constraint>()[group].data();
  for (Index slot = first; slot < end; ++slot) {
    const auto& block = blocks[slot / kBlockLanes];
    const Index lane = slot % kBlockLanes;
    const ParticleOffset corners[2] = {block.corners[0][lane], block.corners[1][lane]};
    const Vec3<float> d =
        load(at(state.bases, corners[1])) - load(at(state.bases, corners[0])) +
        (load(at(state.displacements, corners[1])) - load(at(state.displacements, corners[0])));
    const auto joint = begin_joint(
        loose_end(step, state, corners[0]), loose_end(step, state, corners[1]), d,
        block.parameters[Constraint::kRest][lane], block.parameters[Constraint::kStiffness][lane]);
    float multipliers[Constraint::kMultiplierCount];
    joint.store(multipliers);
    const Index lanes = slot + 1 == size ? kBlockLanes : lane + 1;  // idle ones repeat the last
    for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
      std::fill(stored[slot / kBlockLanes].values[m] + lane,
                stored[slot / kBlockLanes].values[m] + lanes, multipliers[m]);
    }
    for (int k = 0; k < 2; ++k) {
      Particle& flight = at(state.flights, corners[k]);
      flight.w = kToLeastEnergy;
      push_flight(flight, (k == 0 ? 1.0F : -1.0F) * joint.force,
                  at(state.displacements, corners[k]).w, state.inverse_dt_squared);
    }
  }
}

}  // namespace pbdsurg
