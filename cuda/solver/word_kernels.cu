// SPDX-License-Identifier: Apache-2.0
// Kernels that move words about and compute nothing.
#include <cuda_runtime.h>

#include "cuda/check.cuh"
#include "cuda/solver/word_kernels.h"

namespace pbdsurg::cuda {
namespace {

constexpr Index kThreads = 128;

unsigned blocks_for(Index count) {
  return static_cast<unsigned>((count + kThreads - 1) / kThreads);
}

__global__ void write(ArrayStarts arrays, const WordChange* changes, Index count) {
  const auto i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) {
    const WordChange change = changes[i];  // from the host's memory: once for all copies
    const auto array = static_cast<std::uint32_t>(change.array);
    const std::size_t stride = arrays.strides[array];
    const Index copies = stride > 0 ? arrays.copy_count : 1;
    for (Index copy = 0; copy < copies; ++copy) {
      arrays.starts[array][static_cast<std::size_t>(copy) * stride + change.word] = change.value;
    }
  }
}

__global__ void gather(const Particle* particles, const Index* places, Vec3<float>* out,
                       Index count) {
  const auto i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) {
    const Particle p = particles[places[i]];
    out[i] = {p.x, p.y, p.z};
  }
}

// Where entry i of a copy lies in an array of all.
__device__ std::size_t in_copy(Index size, Index i) {
  return blockIdx.y * static_cast<std::size_t>(size) + static_cast<std::size_t>(i);
}

__global__ void gather(DeviceState state, const Index* places, VertexMotion* out, Index count) {
  const auto i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) {
    const std::size_t place = in_copy(state.capacity, places[i]);
    const Particle p = state.particles[place];
    out[in_copy(count, i)] = {p.x,
                              p.y,
                              p.z,
                              state.velocities[place],
                              state.carries == nullptr ? Carry{} : state.carries[place],
                              state.ways == nullptr ? Way{} : state.ways[place],
                              state.ways == nullptr ? Velocity{} : state.velocities_before[place]};
  }
}

__global__ void place_vertices(DeviceState state, const MovedVertex* moved, Index count) {
  const auto i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) {
    const MovedVertex vertex = moved[in_copy(count, i)];
    const std::size_t place = in_copy(state.capacity, vertex.place);
    const VertexMotion& motion = vertex.motion;
    state.particles[place] = {motion.x, motion.y, motion.z, vertex.w};
    state.velocities[place] = motion.velocity;
    if (state.carries != nullptr) {
      state.carries[place] = motion.carry;
    }
    if (state.ways != nullptr) {
      state.ways[place] = motion.way;
      state.velocities_before[place] = motion.velocity_before;
    }
    if (state.forces != nullptr) {
      state.forces[place] = vertex.force;
    }
    if (blockIdx.y == 0 && state.gravities != nullptr) {
      state.gravities[vertex.place] = vertex.gravity;
    }
    if (blockIdx.y == 0) {
      state.vertex_of_place[vertex.place] = vertex.vertex;
    }
  }
}

__global__ void place_forces(DeviceState state, const PlacedForce* placed, Index count) {
  const auto i = static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) {
    const PlacedForce& force = placed[i];
    const std::size_t first =
        static_cast<std::size_t>(force.copy) * static_cast<std::size_t>(state.capacity);
    state.forces[first + static_cast<std::size_t>(force.place)] = force.force;
  }
}

}  // namespace

void check_device_code() {
  cudaFuncAttributes attributes;
  PBDSURG_CUDA_CHECK(cudaFuncGetAttributes(&attributes, reinterpret_cast<const void*>(&write)));
}

void write_words(const ArrayStarts& arrays, const WordChange* changes, Index count,
                 cudaStream_t stream) {
  if (count > 0) {
    write<<<blocks_for(count), kThreads, 0, stream>>>(arrays, changes, count);
    check(cudaGetLastError(), "launching the kernel that writes changes");
  }
}

void gather_positions(const Particle* particles, const Index* places, Vec3<float>* out, Index count,
                      cudaStream_t stream) {
  if (count > 0) {
    gather<<<blocks_for(count), kThreads, 0, stream>>>(particles, places, out, count);
    check(cudaGetLastError(), "launching the kernel that gathers positions");
  }
}

void gather_motion(const DeviceState& state, Index copy_count, const Index* places,
                   VertexMotion* out, Index count, cudaStream_t stream) {
  if (count > 0) {
    const dim3 blocks(blocks_for(count), static_cast<unsigned>(copy_count));
    gather<<<blocks, kThreads, 0, stream>>>(state, places, out, count);
    check(cudaGetLastError(), "launching the kernel that gathers motion");
  }
}

void write_vertices(const DeviceState& state, Index copy_count, const MovedVertex* moved,
                    Index count, cudaStream_t stream) {
  if (count > 0) {
    const dim3 blocks(blocks_for(count), static_cast<unsigned>(copy_count));
    place_vertices<<<blocks, kThreads, 0, stream>>>(state, moved, count);
    check(cudaGetLastError(), "launching the kernel that writes vertices");
  }
}

void write_forces(const DeviceState& state, const PlacedForce* placed, Index count,
                  cudaStream_t stream) {
  if (count > 0) {
    place_forces<<<blocks_for(count), kThreads, 0, stream>>>(state, placed, count);
    check(cudaGetLastError(), "launching the kernel that writes forces");
  }
}

}  // namespace pbdsurg::cuda
