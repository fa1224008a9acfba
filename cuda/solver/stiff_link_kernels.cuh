// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What stiff links need before the sweeps of a substep: a thread a link.

#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/solver/methods/loose_end.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// @tparam kRowsChange  see DeviceLane
template <bool kRowsChange>
__device__ LooseEnd loose_end(const DeviceState& state, const VertexArrays& vertices,
                              const ToolArrays& tools, StepInput* input, Index substep,
                              bool has_tools, Index place) {
  const Index block_lane = __ldg(vertices.lane_of_place + place);
  const Particle p = load_particle(state.displacements + place);
  const FixedPoint point = load_point(state.fixed_points + place);
  if (is_lost(point)) {
    return {{}, {}, true};
  }
  if (block_lane == kInvalidIndex || !(p.w > 0)) {
    return {};
  }
  const Vec3<float> u = position_of(p);
  VertexEnergy<float> start;
  start.add_pull(input->substep.inverse_dt_squared / p.w,
                 position_of(load_particle(state.flights + place)) - u);
  const HeldVertex held{tools,
                        input,
                        substep,
                        place,
                        state.capacity,
                        has_tools ? __ldcg(vertices.holds + block_lane) : kInvalidIndex,
                        {position_of(load_particle(state.particles + place)), u}};
  const VertexRows rows{vertices.blocks, vertices.pulls, vertices.springs, vertices.volumes,
                        vertices.hinges};
  return pbdsurg::loose_end(
      rows, load_ranges(vertices.blocks + block_lane / kBlockLanes),
      DeviceLane<kRowsChange>{state.fixed_points, point, block_lane % kBlockLanes}, start, held);
}

/// Records [first, first + count).
template <bool kRowsChange>
__global__ void __launch_bounds__(kBlockThreads)
    begin_joints(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                 KindArrays<StiffLinkConstraint> links, std::size_t multiplier_count, Index substep,
                 bool has_tools, Index first, Index count) {
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
  vertices = of_copy(vertices);
  input += copy_index();
  if (has_tools) {
    tools = of_copy(tools, state.capacity);
  }
  float* const stored = links.multipliers + copy_index() * multiplier_count;
  LooseEnd ends[2];
  Vec3<float> bases[2], moved[2];
  float w[2];
  for (int k = 0; k < 2; ++k) {
    const Index place = record.places[k];
    ends[k] = loose_end<kRowsChange>(state, vertices, tools, input, substep, has_tools, place);
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
    push_flight(state.flights + record.places[k], (k == 0 ? 1.0F : -1.0F) * joint.force, w[k],
                inverse_dt_squared);
  }
}

void begin_joints(const Stage& stage, Index substep, bool has_tools, const DeviceState& state,
                  const ConstraintArrays& constraints, const VertexArrays& vertices,
                  const ToolArrays& tools, StepInput* input, const Launch& how) {
  launch(how, "launching the start of stiff links", blocks_for(stage.count, kBlockThreads),
         kBlockThreads, vertices.is_damped ? begin_joints<true> : begin_joints<false>, state,
         vertices, tools, input, constraints.of<StiffLinkConstraint>(),
         constraints.multiplier_count, substep, has_tools, stage.first, stage.count);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
