// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The team (lib/coloring/team.h) made of all threads of a cooperative grid.

#include <algorithm>
#include <type_traits>

#include <cooperative_groups.h>
#include <cuda_runtime_api.h>

#include "pbdsurg/base/types.h"

#include "cuda/check.cuh"
#include "lib/coloring/team.h"

namespace pbdsurg::cuda {

/// A group is a block.
class GridTeam {
 public:
  [[nodiscard]] __device__ Index group() const { return static_cast<Index>(blockIdx.x); }
  [[nodiscard]] __device__ Index group_count() const { return static_cast<Index>(gridDim.x); }
  [[nodiscard]] __device__ Index lane() const { return static_cast<Index>(threadIdx.x); }
  [[nodiscard]] __device__ Index lane_count() const { return static_cast<Index>(blockDim.x); }
  [[nodiscard]] __device__ Index worker() const { return group() * lane_count() + lane(); }
  [[nodiscard]] __device__ Index worker_count() const { return group_count() * lane_count(); }
  __device__ void barrier() { cooperative_groups::this_grid().sync(); }

  template <class F>
  __device__ SplitCounts split(Index count, F f, Index* one, Index* two = nullptr) {
    __shared__ SplitCounts counts;
    __syncthreads();  // the last use is over
    if (threadIdx.x == 0) {
      counts = {0, 0};
    }
    __syncthreads();
    for (Index i = lane(); i < count; i += lane_count()) {
      const Sorted sorted = f(i);
      if (sorted.place == Place::one) {
        one[take_number(counts.one)] = sorted.index;
      } else if (sorted.place == Place::two) {
        two[take_number(counts.two)] = sorted.index;
      }
    }
    __syncthreads();
    return counts;
  }

  __device__ static void raise(Index& flag) { *static_cast<volatile Index*>(&flag) = 1; }

  template <class T>
  __device__ static T peek(const T& value) {
    return *static_cast<const volatile T*>(&value);
  }

  template <class T>
  __device__ static T fetch_max(T& target, std::type_identity_t<T> value) {
    return static_cast<T>(atomicMax(native(target), static_cast<Native<T>>(value)));
  }
  template <class T>
  __device__ static T fetch_or(T& target, std::type_identity_t<T> value) {
    return static_cast<T>(atomicOr(native(target), static_cast<Native<T>>(value)));
  }
  template <class T>
  __device__ static T fetch_and(T& target, std::type_identity_t<T> value) {
    return static_cast<T>(atomicAnd(native(target), static_cast<Native<T>>(value)));
  }
  template <class T>
  __device__ static T fetch_add(T& target, std::type_identity_t<T> value) {
    return static_cast<T>(atomicAdd(native(target), static_cast<Native<T>>(value)));
  }

 private:
  // the types that CUDA's atomics are declared for
  template <class T>
  using Native = std::conditional_t<sizeof(T) == 8, unsigned long long,
                                    std::conditional_t<std::is_signed_v<T>, int, unsigned int>>;
  template <class T>
  __device__ static Native<T>* native(T& target) {
    return reinterpret_cast<Native<T>*>(&target);
  }

  // One atomic for all threads of a warp that come here together.
  __device__ static Index take_number(Index& counter) {
    const auto together = cooperative_groups::coalesced_threads();
    Index first = 0;
    if (together.thread_rank() == 0) {
      first = atomicAdd(&counter, static_cast<Index>(together.size()));
    }
    return together.shfl(first, 0) + static_cast<Index>(together.thread_rank());
  }
};

inline constexpr int kTeamBlock = 512;  // threads

template <class Program>
__global__ void __launch_bounds__(kTeamBlock) run_program(Program program) {
  GridTeam team;
  program(team);
}

/// Runs program(team) on a grid.
/// @param items           one a thread is enough
/// @param blocks_at_most  for each multiprocessor: fewer make barriers cheaper, more hide latency
template <class Program>
void run_on_grid(const Program& program, Index items, int blocks_at_most, cudaStream_t stream) {
  int device = 0;
  int processors = 0;
  int blocks_each = 0;
  PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
  PBDSURG_CUDA_CHECK(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device));
  PBDSURG_CUDA_CHECK(cudaOccupancyMaxActiveBlocksPerMultiprocessor(
      &blocks_each, run_program<Program>, kTeamBlock, 0));
  const int enough = std::max(1, (items + kTeamBlock - 1) / kTeamBlock);
  const int blocks = std::min(processors * std::min(blocks_each, blocks_at_most), enough);
  void* arguments[] = {const_cast<Program*>(&program)};
  PBDSURG_CUDA_CHECK(cudaLaunchCooperativeKernel(
      reinterpret_cast<const void*>(&run_program<Program>), dim3(static_cast<unsigned>(blocks)),
      dim3(kTeamBlock), arguments, 0, stream));
}

}  // namespace pbdsurg::cuda
