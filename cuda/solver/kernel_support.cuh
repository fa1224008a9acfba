// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What kernels of a step have in common. Included in each of the two compilations of them, whose
/// namespace keeps them apart.

#include <utility>

#include <cuda_runtime.h>

#include "pbdsurg/base/vec3.h"

#include "cuda/check.cuh"
#include "cuda/solver/step_kernels.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kWarp = 32;

/// As kTetEdges of mesh/topology.h, whose Eigen stays out of kernels.
__device__ constexpr int kTetEdgeEnds[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// First of all in every kernel that reads what others have written; no thread may leave before,
/// or the kernel might end before the one that it follows.
__device__ inline void wait_for_previous() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}

__device__ inline Index thread_index() {
  return static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
}
__device__ inline Index thread_count() {
  return static_cast<Index>(gridDim.x * blockDim.x);
}

/// The copy of the scene that this block works on.
__device__ inline std::size_t copy_index() {
  return blockIdx.y;
}

/// How many vertices a step has. The host wrote that before its first kernel, so it may be read
/// while the kernel before is at work.
__device__ inline Index vertex_count(const StepInput* input) {
  return __ldg(&input->vertex_count);
}

/// What a copy has of arrays of all.
__device__ inline DeviceState of_copy(DeviceState state) {
  const std::size_t first = copy_index() * static_cast<std::size_t>(state.capacity);
  state.particles += first;
  state.velocities += first;
  if (state.displacements == nullptr) {
    state.previous += first;
  } else {
    state.displacements += first;
    state.carries += first;
    if (state.flights != nullptr) {
      state.flights += first;
      state.fixed_points += first;
      state.ends.ways += first;
      state.ends.gives += first;
      state.ends.shears += first;
    }
    if (state.ways != nullptr) {
      state.ways += first;
      state.velocities_before += first;
    }
  }
  if (state.forces != nullptr) {
    state.forces += first;
  }
  return state;
}

/// Where a row of an array begins: of a tool, or of a substep.
__device__ inline std::size_t row_at(Index row, Index stride) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride);
}

/// Reads what no kernel of the step writes, in 16-byte words.
template <class Record>
__device__ Record load_constant(const Record* record) {
  static_assert(sizeof(Record) % sizeof(int4) == 0 && alignof(Record) == alignof(int4));
  Record result;
  const int4* const from = reinterpret_cast<const int4*>(record);
  int4* const to = reinterpret_cast<int4*>(&result);
#pragma unroll
  for (unsigned i = 0; i < sizeof(Record) / sizeof(int4); ++i) {
    to[i] = __ldg(from + i);
  }
  return result;
}

/// As it is in the memory that all blocks share, past a cache that may be out of date.
__device__ inline Particle load_particle(const Particle* particle) {
  const float4 p = __ldcg(reinterpret_cast<const float4*>(particle));
  return {p.x, p.y, p.z, p.w};
}
__device__ inline void store_particle(Particle* particle, const Vec3<float>& x, float w) {
  *reinterpret_cast<float4*>(particle) = make_float4(x.x, x.y, x.z, w);
}
__device__ inline Vec3<float> position_of(const Particle& p) {
  return {p.x, p.y, p.z};
}
__device__ inline Carry load_carry(const Carry* carry) {
  const float4 c = __ldcg(reinterpret_cast<const float4*>(carry));
  return {c.x, c.y, c.z, c.w};
}

__device__ inline FixedPoint load_point(const FixedPoint* point) {
  const uint4 p = __ldcg(reinterpret_cast<const uint4*>(point));
  return {p.x, p.y, p.z, __uint_as_float(p.w)};
}
__device__ inline void store_point(FixedPoint* to, const FixedPoint& point) {
  *reinterpret_cast<uint4*>(to) =
      make_uint4(point.x, point.y, point.z, __float_as_uint(point.unit));
}

/// What moves in a substep, as in MovingVertices.
__host__ __device__ inline Particle* moving_of(const DeviceState& state) {
  return state.displacements == nullptr ? state.particles : state.displacements;
}
__device__ inline Vec3<float> base_of(const DeviceState& state, Index place) {
  return state.displacements == nullptr ? Vec3<float>{}
                                        : position_of(load_particle(state.particles + place));
}

__device__ inline bool is_finite(float value) {
  return fabsf(value) < kInfinity;
}
__device__ inline bool is_finite(const Vec3<float>& v) {
  return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}

/// Whether this block is the last of its copy to get here. What all of these blocks wrote before is
/// then there for it to read, past caches. All threads of a block call it.
/// @param blocks_done  of the copy
__device__ inline bool is_last_block(std::uint32_t* blocks_done) {
  __shared__ bool is_last;
  __threadfence();
  __syncthreads();
  if (threadIdx.x == 0) {
    is_last = atomicInc(blocks_done, gridDim.x - 1) == gridDim.x - 1;  // back to zero by itself
  }
  __syncthreads();
  __threadfence();
  return is_last;
}

/// Shared memory for what has initial values elsewhere: here it has none.
template <class T>
struct SharedRoom {
  alignas(T) unsigned char bytes[sizeof(T)];

  __device__ T& get() { return *reinterpret_cast<T*>(bytes); }
};

/// Of the current device.
inline int device_attribute(cudaDeviceAttr which) {
  int device = 0;
  int value = 0;
  check(cudaGetDevice(&device), "asking for the current device");
  check(cudaDeviceGetAttribute(&value, which, device), "asking for an attribute of the device");
  return value;
}

/// So many blocks that copies together have about as many, but `least` at least for each.
inline int share_blocks(int blocks, int least, const Launch& how) {
  const int share = blocks / static_cast<int>(how.copies);
  return share < least ? least : share;
}

/// At least one: a launch of none is an error.
inline int blocks_for(Index count, int threads) {
  return count <= threads ? 1 : (count - 1) / threads + 1;
}

/// @param name    for the message if it fails
/// @param blocks  for each copy
/// @param memory  bytes of dynamic shared memory
template <class... Parameters, class... Arguments>
void launch_with_memory(const Launch& how, const char* name, int blocks, int threads,
                        std::size_t memory, void (*kernel)(Parameters...),
                        Arguments&&... arguments) {
  cudaLaunchAttribute overlap{};
  overlap.id = cudaLaunchAttributeProgrammaticStreamSerialization;
  overlap.val.programmaticStreamSerializationAllowed = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(static_cast<unsigned>(blocks), static_cast<unsigned>(how.copies));
  config.blockDim = dim3(static_cast<unsigned>(threads));
  config.dynamicSmemBytes = memory;
  config.stream = how.stream;
  config.attrs = &overlap;
  config.numAttrs = how.overlaps ? 1 : 0;
  check(cudaLaunchKernelEx(&config, kernel, std::forward<Arguments>(arguments)...), name);
}

/// Likewise without such memory.
template <class... Parameters, class... Arguments>
void launch(const Launch& how, const char* name, int blocks, int threads,
            void (*kernel)(Parameters...), Arguments&&... arguments) {
  launch_with_memory(how, name, blocks, threads, 0, kernel, std::forward<Arguments>(arguments)...);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
