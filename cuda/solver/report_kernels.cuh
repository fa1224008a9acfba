// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a step has to report of the state that it leaves, and what the host wants to see of it.

#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/volume.h"

#include "cuda/solver/kernel_support.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kReportThreads = 256;
constexpr int kMostReportBlocks = 264;  // two on each multiprocessor of the largest devices
constexpr int kLeastReportBlocks = 8;   // for each of many copies, of those that it needs

/// What one thread has seen.
struct Seen {
  Index inverted = 0;
  Index non_finite = 0;
  Index first_non_finite = 0x7fffffff;
  float distance = 0;
  float volume = 0;
};

/// A residual that is not a number counts as infinite: it must not hide behind the finite ones.
__device__ inline void raise(float& largest, float value) {
  if (!(value < kInfinity)) {
    largest = kInfinity;
  } else if (value > largest) {
    largest = value;
  }
}

template <int kVertices>
__device__ void load_corners(const Particle* particles, const Index (&places)[kVertices],
                             Vec3<float> (&x)[kVertices]) {
#pragma unroll
  for (int k = 0; k < kVertices; ++k) {
    x[k] = position_of(load_particle(particles + places[k]));
  }
}

__device__ inline void see_vertices(const DeviceState& state, Index count, Seen& seen) {
  for (Index i = thread_index(); i < count; i += thread_count()) {
    if (!is_finite(position_of(load_particle(state.particles + i)))) {
      const Index vertex = __ldg(state.vertex_of_place + i);
      ++seen.non_finite;
      seen.first_non_finite = vertex < seen.first_non_finite ? vertex : seen.first_non_finite;
    }
  }
}

__device__ inline void see_distance(const Vec3<float> (&x)[2], float rest, Seen& seen) {
  if (rest > 0) {
    raise(seen.distance, fabsf(DistanceConstraint::value(x, rest)) / rest);
  }
}

__device__ inline void see_volume(const Vec3<float> (&x)[4], float rest, Seen& seen) {
  const float value = VolumeConstraint::value(x, rest);
  raise(seen.volume, fabsf(value) / rest);
  seen.inverted += value + rest < 0 ? 1 : 0;
}

__device__ inline void see_distances(const Particle* particles, const ConstraintArrays& all,
                                     Seen& seen) {
  for (Index i = thread_index(); i < all.of<DistanceConstraint>().count; i += thread_count()) {
    const auto record = load_constant(all.of<DistanceConstraint>().records + i);
    if (record.places[0] >= 0) {
      Vec3<float> x[2];
      load_corners(particles, record.places, x);
      see_distance(x, record.parameters[DistanceConstraint::kRest], seen);
    }
  }
}

__device__ inline void see_volumes(const Particle* particles, const ConstraintArrays& all,
                                   Seen& seen) {
  for (Index i = thread_index(); i < all.of<VolumeConstraint>().count; i += thread_count()) {
    const auto record = load_constant(all.of<VolumeConstraint>().records + i);
    if (record.places[0] >= 0) {
      Vec3<float> x[4];
      load_corners(particles, record.places, x);
      see_volume(x, record.parameters[VolumeConstraint::kRest], seen);
    }
  }
}

__device__ inline void see_joints(const Particle* particles, const ConstraintArrays& all,
                                  Seen& seen) {
  for (Index i = thread_index(); i < all.joint_count; i += thread_count()) {
    const JointRecord record = load_constant(all.joints + i);
    if (record.places[0] >= 0) {
      Vec3<float> x[4];
      load_corners(particles, record.places, x);
      see_volume(x, record.rest, seen);
#pragma unroll
      for (int k = 0; k < 6; ++k) {
        const Vec3<float> ends[2] = {x[kTetEdgeEnds[k][0]], x[kTetEdgeEnds[k][1]]};
        see_distance(ends, record.edge_rest[k], seen);
      }
    }
  }
}

__device__ inline void see_neo_hookeans(const Particle* particles, const ConstraintArrays& all,
                                        Seen& seen) {
  for (Index i = thread_index(); i < all.of<NeoHookeanConstraint>().count; i += thread_count()) {
    const auto record = load_constant(all.of<NeoHookeanConstraint>().records + i);
    if (record.places[0] >= 0) {
      Vec3<float> x[4];
      load_corners(particles, record.places, x);
      const float value = NeoHookeanConstraint::value(x, record.parameters);
      raise(seen.volume, fabsf(value));
      seen.inverted += value < -1 ? 1 : 0;
    }
  }
}

__device__ inline void see_tubes(const Particle* particles, const ConstraintArrays& all,
                                 Seen& seen) {
  for (Index i = thread_index(); i < all.tube_count; i += thread_count()) {
    const TubeRecord record = load_constant(all.tubes + i);
    if (record.places[0] >= 0) {
      Vec3<float> x[4];
      load_corners(particles, record.places, x);
      seen.inverted += VolumeConstraint::value(x, 0.0F) < 0 ? 1 : 0;
    }
  }
}

template <class Combine>
__device__ auto over_warp(Combine combine, decltype(combine(0, 0)) value) {
  for (int offset = kWarp / 2; offset > 0; offset /= 2) {
    value = combine(value, __shfl_xor_sync(~0U, value, offset));
  }
  return value;
}

/// Adds what a warp has seen. Integers only: floats >= 0 are ordered as their bits are.
__device__ inline void add(const Seen& seen, StepSums& sums) {
  const auto sum = [](Index a, Index b) { return a + b; };
  const auto least = [](Index a, Index b) { return a < b ? a : b; };
  const auto most = [](Index a, Index b) { return a < b ? b : a; };
  const Index inverted = over_warp(sum, seen.inverted);
  const Index non_finite = over_warp(sum, seen.non_finite);
  const Index first = over_warp(least, seen.first_non_finite);
  const Index distance = over_warp(most, __float_as_int(seen.distance));
  const Index volume = over_warp(most, __float_as_int(seen.volume));
  if (threadIdx.x % kWarp == 0) {
    if (inverted > 0) {
      atomicAdd(&sums.inverted_tets, inverted);
    }
    if (non_finite > 0) {
      atomicAdd(&sums.non_finite_vertices, non_finite);
      atomicMin(&sums.first_non_finite, first);
    }
    atomicMax(&sums.distance_residual, static_cast<std::uint32_t>(distance));
    atomicMax(&sums.volume_residual, static_cast<std::uint32_t>(volume));
  }
}

__global__ void __launch_bounds__(kReportThreads)
    see(DeviceState state, ConstraintArrays constraints, StepInput* input, StepOutput output) {
  wait_for_previous();
  state = of_copy(state);
  input += copy_index();
  Seen seen;
  see_vertices(state, vertex_count(input), seen);
  see_distances(state.particles, constraints, seen);
  see_volumes(state.particles, constraints, seen);
  see_joints(state.particles, constraints, seen);
  see_neo_hookeans(state.particles, constraints, seen);
  see_tubes(state.particles, constraints, seen);
  add(seen, input->sums);
  Vec3<float>* const watched =
      output.watched + copy_index() * static_cast<std::size_t>(input->watched_count);
  for (Index i = thread_index(); i < input->watched_count; i += thread_count()) {
    watched[i] = position_of(load_particle(state.particles + __ldg(output.watched_places + i)));
  }
  if (is_last_block(&input->sums.blocks_done)) {
    const Wrench* const wrenches = table<Wrench>(input, input->wrenches);
    Wrench* const out =
        output.wrenches + copy_index() * static_cast<std::size_t>(input->tool_count);
    for (Index t = static_cast<Index>(threadIdx.x); t < input->tool_count; t += kReportThreads) {
      out[t] = wrenches[t];
    }
    constexpr Index kWords = sizeof(StepSums) / sizeof(std::uint32_t);
    if (threadIdx.x < kWords) {
      reinterpret_cast<std::uint32_t*>(output.sums + copy_index())[threadIdx.x] =
          __ldcg(reinterpret_cast<const std::uint32_t*>(&input->sums) + threadIdx.x);
    }
  }
}

void report(const DeviceState& state, const ConstraintArrays& constraints, StepInput* input,
            const StepOutput& output, const Launch& how) {
  Index most = state.capacity;
  for (const Index count : {constraints.of<DistanceConstraint>().count,
                            constraints.of<VolumeConstraint>().count, constraints.joint_count,
                            constraints.of<NeoHookeanConstraint>().count, constraints.tube_count}) {
    most = most < count ? count : most;
  }
  const int needed = blocks_for(most, kReportThreads);
  const int share = share_blocks(kMostReportBlocks, kLeastReportBlocks, how);
  launch(how, "launching the report", needed < share ? needed : share, kReportThreads, see, state,
         constraints, input, output);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
