// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What stiff links need before the sweeps of a substep: how their ends give way, then a thread a
/// link.

#include "cuda/solver/project_kernels.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/solver/methods/loose_end.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

__device__ inline LooseEnd<float> load_end(const LinkEnds& ends, Index place) {
  const Particle way = load_particle(ends.ways + place);
  const Particle give = load_particle(ends.gives + place);
  const Particle shear = load_particle(ends.shears + place);
  return {{give.x, give.y, give.z, shear.x, shear.y, shear.z}, position_of(way), way.w};
}

__device__ inline void store_end(const LinkEnds& ends, Index place, const LooseEnd<float>& end) {
  const VertexGive<float>& give = end.give;
  store_particle(ends.ways + place, end.way, end.is_known);
  store_particle(ends.gives + place, {give.xx, give.yy, give.zz}, 0);
  store_particle(ends.shears + place, {give.xy, give.xz, give.yz}, 0);
}

/// The energy of a vertex, by its inertia and its neighbours. kVertexParts threads share its rows,
/// neighbours in a warp: all of them call this, and each has what they find.
/// @param block   that has it
/// @param access  to its lane: see LaneAccess
/// @param place   of a vertex that is not lost
/// @param part    of this thread
template <class Access>
__device__ VertexEnergy<float> energy_of(const DeviceState& state, const VertexArrays& vertices,
                                         const StepInput* input, Index block, const Access& access,
                                         Index place, Index part) {
  const Particle p = load_particle(state.displacements + place);
  VertexEnergy<float> start;
  start.add_pull(input->substep.inverse_dt_squared / p.w,
                 position_of(load_particle(state.flights + place)) - position_of(p));
  const VertexRows rows = rows_of(vertices);
  const VertexBlock ranges = load_ranges<true>(vertices.blocks + block);
  VertexEnergy<float> energy{};
  if (part == 0) {
    energy = start;
  }
  add_rows(rows, ranges, access, energy, {part, kVertexParts});
  add_up<kVertexParts>(energy, mask_of_parts<kVertexParts>());
  return finite_energy(rows, ranges, access, start, energy);
}

/// How such a vertex gives way, likewise.
/// @tparam kRowsChange  see DeviceLane
/// @param part          of this thread
template <bool kRowsChange>
__device__ LooseEnd<float> find_loose_end(const DeviceState& state, const VertexArrays& vertices,
                                          const ToolArrays& tools, StepInput* input, Index substep,
                                          bool has_tools, Index place, Index part) {
  const Index block_lane = __ldg(vertices.lane_of_place + place);
  const Particle p = load_particle(state.displacements + place);
  const FixedPoint point = load_point(state.fixed_points + place);
  if (is_lost(point)) {
    return {{}, {}, 0};
  }
  if (block_lane == kInvalidIndex || !(p.w > 0)) {
    return {};
  }
  const HeldVertex<true> held{
      state,
      tools,
      input,
      substep,
      place,
      has_tools ? __ldcg(vertices.holds + block_lane) : kInvalidIndex,
      {position_of(load_particle(state.particles + place)), position_of(p)}};
  const DeviceLane<kRowsChange> access{state.fixed_points, point, block_lane % kBlockLanes};
  return pbdsurg::find_loose_end(
      energy_of(state, vertices, input, block_lane / kBlockLanes, access, place, part), held);
}

/// Both ends of all records, kVertexParts threads each; those with the same end write the same
/// bits.
template <bool kRowsChange>
__global__ void __launch_bounds__(kBlockThreads)
    find_loose_ends(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                    KindArrays<StiffLinkConstraint> links, Index substep, bool has_tools) {
  wait_for_previous();
  const Index end = thread_index() / kVertexParts, part = thread_index() % kVertexParts;
  if (end / 2 >= links.count) {
    return;
  }
  const auto record = load_constant(links.records + end / 2);
  if (record.places[0] < 0) {
    return;
  }
  const Index place = record.places[end % 2];
  state = of_copy(state);
  vertices = of_copy(vertices);
  input += copy_index();
  if (has_tools) {
    tools = of_copy(tools, state.capacity);
  }
  const LooseEnd<float> found =
      find_loose_end<kRowsChange>(state, vertices, tools, input, substep, has_tools, place, part);
  if (part == 0) {
    store_end(state.ends, place, found);
  }
}

/// Records [first, first + count).
__global__ void __launch_bounds__(kBlockThreads)
    begin_links(DeviceState state, const StepInput* input, KindArrays<StiffLinkConstraint> links,
                std::size_t multiplier_count, Index first, Index count) {
  using Constraint = StiffLinkConstraint;
  wait_for_previous();
  const Index i = first + thread_index();
  if (thread_index() >= count) {
    return;
  }
  const auto record = load_constant(links.records + i);
  if (record.places[0] < 0) {
    return;
  }
  state = of_copy(state);
  input += copy_index();
  float* const stored = links.multipliers + copy_index() * multiplier_count;
  LooseEnd<float> ends[2];
  Vec3<float> bases[2], moved[2];
  float w[2];
  for (int k = 0; k < 2; ++k) {
    const Index place = record.places[k];
    ends[k] = load_end(state.ends, place);
    bases[k] = position_of(load_particle(state.particles + place));
    const Particle p = load_particle(state.displacements + place);
    moved[k] = position_of(p);
    w[k] = p.w;
  }
  const Vec3<float> d = (bases[1] - bases[0]) + (moved[1] - moved[0]);
  const auto joint = begin_joint(ends[0], ends[1], d, record.parameters[Constraint::kRest],
                                 record.parameters[Constraint::kStiffness]);
  float multipliers[Constraint::kMultiplierCount];
  joint.store(multipliers);
  for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
    stored[m * links.count + i] = multipliers[m];
  }
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  for (int k = 0; k < 2; ++k) {
    const Index place = record.places[k];
    const Vec3<float> force = (k == 0 ? 1.0F : -1.0F) * joint.force;
    ends[k].push(force);
    store_particle(state.ends.ways + place, ends[k].way, ends[k].is_known);
    push_flight(state.flights + place, force, w[k], inverse_dt_squared);
  }
}

void find_loose_ends(Index substep, bool has_tools, const DeviceState& state,
                     const ConstraintArrays& constraints, const VertexArrays& vertices,
                     const ToolArrays& tools, StepInput* input, const Launch& how) {
  const KindArrays<StiffLinkConstraint>& links = constraints.of<StiffLinkConstraint>();
  launch(how, "launching the search for ends of stiff links",
         blocks_for(2 * links.count * kVertexParts, kBlockThreads), kBlockThreads,
         vertices.is_damped ? find_loose_ends<true> : find_loose_ends<false>, state, vertices,
         tools, input, links, substep, has_tools);
}

void begin_joints(const Stage& stage, const DeviceState& state, const ConstraintArrays& constraints,
                  const StepInput* input, const Launch& how) {
  launch(how, "launching the start of stiff links", blocks_for(stage.count, kBlockThreads),
         kBlockThreads, begin_links, state, input, constraints.of<StiffLinkConstraint>(),
         constraints.multiplier_count, stage.first, stage.count);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
