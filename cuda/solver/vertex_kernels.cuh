// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Prediction and velocities: a thread a vertex.

#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/methods/displacement.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kVertexThreads = 128;

__device__ inline Vec3<float> load_velocity(const Velocity* velocity) {
  const float4 v = __ldcg(reinterpret_cast<const float4*>(velocity));
  return {v.x, v.y, v.z};
}
__device__ inline void store_velocity(Velocity* velocity, const Vec3<float>& v) {
  *reinterpret_cast<float4*>(velocity) = make_float4(v.x, v.y, v.z, 0);
}

__device__ inline Load load_load(const Load* load) {
  const float4 v = __ldg(reinterpret_cast<const float4*>(load));  // no kernel of a step writes it
  return {v.x, v.y, v.z, v.w};
}

/// As on the host, of a vertex of this copy.
__device__ inline FreeMotion<float> falling_motion(const DeviceState& state,
                                                   const FreeMotion<float>& motion, Index place) {
  if (state.gravities == nullptr) {
    return motion;
  }
  const Load gravity = load_load(state.gravities + place);
  return under(Vec3<float>{gravity.x, gravity.y, gravity.z}, gravity.inverse_square, motion);
}
__device__ inline FreeMotion<float> flying_motion(const DeviceState& state,
                                                  const FreeMotion<float>& falling, float w,
                                                  Index place) {
  if (state.forces == nullptr) {
    return falling;
  }
  const Load force = load_load(state.forces + place);
  return pushed_by(Vec3<float>{force.x, force.y, force.z}, w, falling);
}

/// The end of one substep and the beginning of the next are one kernel: the velocity stays in a
/// register between them.
template <bool kEnds, bool kBegins>
__global__ void __launch_bounds__(kVertexThreads)
    advance_positions(DeviceState state, const StepInput* input) {
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const Index i = thread_index();
  if (i >= count) {
    return;
  }
  const Particle p = load_particle(state.particles + i);
  const Vec3<float> x = position_of(p);
  const FreeMotion<float> motion =
      flying_motion(state, falling_motion(state, input[copy_index()].motion, i), p.w, i);
  Vec3<float> velocity;
  if constexpr (kEnds) {
    velocity = motion.inverse_h * (x - position_of(load_particle(state.previous + i)));
  } else {
    velocity = load_velocity(state.velocities + i);
  }
  if constexpr (kBegins) {
    store_particle(state.previous + i, x, p.w);
    if (p.w > 0) {
      store_particle(state.particles + i, x + motion.h * (motion.keep * velocity + motion.kick),
                     p.w);
    }
  } else {
    store_velocity(state.velocities + i, velocity);
  }
}

__device__ inline Vec3<float> load_way(const Way* way) {
  const float4 v = __ldcg(reinterpret_cast<const float4*>(way));
  return {v.x, v.y, v.z};
}
__device__ inline void store_way(Way* way, const Vec3<float>& v) {
  *reinterpret_cast<float4*>(way) = make_float4(v.x, v.y, v.z, 0);
}
__device__ inline void store_carry(Carry* carry, const Vec3<float>& rounding, float falling) {
  *reinterpret_cast<float4*>(carry) = make_float4(rounding.x, rounding.y, rounding.z, falling);
}

/// Likewise of displacements: see displacement.h.
/// @tparam kHasPast  of BDF2: recall_past() and keep_past() are part of it
template <bool kEnds, bool kBegins, bool kHasPast>
__global__ void __launch_bounds__(kVertexThreads)
    advance_displacements(DeviceState state, const StepInput* input) {
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const Index i = thread_index();
  if (i >= count) {
    return;
  }
  input += copy_index();
  const Particle p = load_particle(state.particles + i);
  const FreeMotion<float> motion = falling_motion(state, input->motion, i);
  Vec3<float> velocity = load_velocity(state.velocities + i);
  const Carry carry = load_carry(state.carries + i);
  Vec3<float> rounding{carry.x, carry.y, carry.z};
  float falling = carry.falling;
  Vec3<float> x = position_of(p);
  if constexpr (kEnds) {
    const Vec3<float> u = position_of(load_particle(state.displacements + i));
    const Settled<float> end = settle(motion, x, p.w, velocity, rounding, u);
    velocity = end.velocity;
    rounding = end.rounding;
    falling = end.falling;
    x = end.x;
    store_particle(state.particles + i, x, p.w);
    store_velocity(state.velocities + i, velocity);
    store_carry(state.carries + i, rounding, falling);
    if constexpr (kHasPast) {
      store_way(state.ways + i, u - load_way(state.ways + i));
    }
  }
  if constexpr (kBegins) {
    if constexpr (kHasPast) {
      const Departure<float> next =
          departure_after({velocity, rounding}, p.w, input->past_share, load_way(state.ways + i),
                          load_velocity(state.velocities_before + i));
      store_way(state.ways + i, rounding);
      store_velocity(state.velocities_before + i, velocity);
      velocity = next.velocity;
      rounding = next.rounding;
      store_velocity(state.velocities + i, velocity);
      store_carry(state.carries + i, rounding, falling);
    }
    const FreeMotion<float> flying = flying_motion(state, motion, p.w, i);
    Vec3<float> u = flight_of(flying, rounding, flying_velocity(flying, velocity, p.w));
    if (state.flights != nullptr) {
      store_particle(state.flights + i, u, kFreely);
      if (state.forces != nullptr) {
        u = flight_of(motion, rounding, flying_velocity(motion, velocity, p.w));
      }
      u = start_of(motion, u, p.w, falling);
      store_point(state.fixed_points + i, fixed_point(x, state.starts ? rounding : u, input->unit));
    }
    store_particle(state.displacements + i, u, p.w);
  }
}

/// What the code that runs on the current device was compiled for, 90 of compute capability 9.0:
/// less than the device's own where the driver made it of an older one.
int code_architecture() {
  cudaFuncAttributes attributes{};
  check(cudaFuncGetAttributes(&attributes,
                              reinterpret_cast<const void*>(&advance_positions<true, true>)),
        "asking what kernels were compiled for");
  return attributes.ptxVersion;
}

void advance(const DeviceState& state, const StepInput* input, bool ends, bool begins,
             const Launch& how) {
  const auto choose = [&](auto* both, auto* end, auto* begin) {
    return !begins ? end : ends ? both : begin;
  };
  auto* kernel = choose(advance_positions<true, true>, advance_positions<true, false>,
                        advance_positions<false, true>);
  if (state.ways != nullptr) {
    kernel =
        choose(advance_displacements<true, true, true>, advance_displacements<true, false, true>,
               advance_displacements<false, true, true>);
  } else if (state.displacements != nullptr) {
    kernel =
        choose(advance_displacements<true, true, false>, advance_displacements<true, false, false>,
               advance_displacements<false, true, false>);
  }
  launch(how, "launching a prediction", blocks_for(state.capacity, kVertexThreads), kVertexThreads,
         kernel, state, input);
}

__global__ void take_later(StepInput* inputs, Index copies) {
  const Index copy = thread_index();
  wait_for_previous();
  if (copy < copies) {
    StepInput& input = inputs[copy];
    input.motion = input.later_motion;
    input.substep = input.later_substep;
    input.past_share = input.later_past_share;
    input.force_per_multiplier = input.later_force_per_multiplier;
  }
}

void take_later_lengths(StepInput* inputs, const Launch& how) {
  launch({how.stream, how.overlaps}, "launching a change of lengths",
         blocks_for(how.copies, kVertexThreads), kVertexThreads, take_later, inputs, how.copies);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
