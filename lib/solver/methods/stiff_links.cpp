// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/stiff_links.h"

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

void store_end(const LooseEnd<float>& end, const LinkEnds& ends, ParticleOffset corner) {
  at(ends.ways, corner) = {end.way.x, end.way.y, end.way.z, end.is_known};
  at(ends.gives, corner) = {end.give.xx, end.give.yy, end.give.zz, 0};
  at(ends.shears, corner) = {end.give.xy, end.give.xz, end.give.yz, 0};
}

}  // namespace

void find_loose_ends(const StepContext& step, const VertexState& state, Index block_index,
                     LaneBits lanes) {
  const VertexRows rows = vertex_rows(step);
  const VertexBlock& block = rows.blocks[block_index];
  const LinkEnds ends = step.scratch.link_ends();
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    if ((lanes >> lane & 1) == 0) {
      continue;
    }
    const ParticleOffset corner = block.corners[lane];
    const Particle& p = at(state.displacements, corner);
    const FixedPoint& point = at(state.fixed_points, corner);
    LooseEnd<float> end;
    if (is_lost(point)) {
      end.is_known = 0;
    } else if (p.w > 0) {
      const Vec3<float> u = load(p);
      VertexEnergy<float> start;
      start.add_pull(state.inverse_dt_squared / p.w, load(at(state.flights, corner)) - u);
      const LaneAccess access{state.fixed_points, point, lane};
      end = find_loose_end(finite_energy(rows, block, access, start),
                           HeldVertex(step, {load(at(state.bases, corner)), u},
                                      step.scratch.first_holds[place_at(corner)]));
    }
    store_end(end, ends, corner);
  }
}

void find_lone_ends(const StepContext& step, const VertexState& state) {
  for (const ParticleOffset corner : step.scratch.lone_ends) {
    LooseEnd<float> end;
    end.is_known = is_lost(at(state.fixed_points, corner)) ? 0 : 1;
    store_end(end, step.scratch.link_ends(), corner);
  }
}

void begin_joints(const StepContext& step, const VertexState& state, Index group) {
  using Constraint = StiffLinkConstraint;
  const ConstraintSlots<Constraint>& slots = step.data.sets.of<Constraint>();
  const auto* const blocks = slots.blocks(group).data();
  auto* const stored = step.scratch.multipliers.of<Constraint>()[group].data();
  const LinkEnds ends = step.scratch.link_ends();
  for (Index slot = 0; slot < slots.size(group); ++slot) {
    const auto& block = blocks[slot / kBlockLanes];
    const Index lane = slot % kBlockLanes;
    const ParticleOffset corners[2] = {block.corners[0][lane], block.corners[1][lane]};
    LooseEnd<float> pair[2] = {load_end(ends, corners[0]), load_end(ends, corners[1])};
    const Vec3<float> d =
        load(at(state.bases, corners[1])) - load(at(state.bases, corners[0])) +
        (load(at(state.displacements, corners[1])) - load(at(state.displacements, corners[0])));
    const auto joint = begin_joint(pair[0], pair[1], d, block.parameters[Constraint::kRest][lane],
                                   block.parameters[Constraint::kStiffness][lane]);
    float multipliers[Constraint::kMultiplierCount];
    joint.store(multipliers);
    for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
      stored[slot / kBlockLanes].values[m][lane] = multipliers[m];
    }
    for (int k = 0; k < 2; ++k) {
      const Vec3<float> force = (k == 0 ? 1.0F : -1.0F) * joint.force;
      pair[k].push(force);
      store(at(ends.ways, corners[k]), pair[k].way);
      Particle& flight = at(state.flights, corners[k]);
      flight.w = kToLeastEnergy;
      push_flight(flight, force, at(state.displacements, corners[k]).w, state.inverse_dt_squared);
    }
  }
}

}  // namespace pbdsurg
