// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a block of the cluster that solves a system keeps, and how its threads meet and add.

#include <cstdint>

#include <cuda_runtime.h>

#include "cuda/heat/system_kernel.h"
#include "cuda/solver/cluster_memory.cuh"

namespace pbdsurg::cuda {
namespace {

constexpr int kWarp = 32;
constexpr int kWarps = kSystemThreads / kWarp;
constexpr int kThreadsPerPiece = kSystemThreads / kMostPieces;
constexpr unsigned kAllLanes = 0xffffffff;

// A column in the low bits, the tag of its row in the high ones: the group, or that it is held.
constexpr int kTagShift = 25;
constexpr std::uint32_t kColumnBits = (1U << kTagShift) - 1;
constexpr std::uint32_t kHeldTag = kMostPieces;

enum Sum { kSquares, kTotals, kCurvatures, kSquaresOfZero };
static_assert(kSquaresOfZero + 1 == kSystemSums);

/// Of a block, besides what it stores.
struct alignas(16) SharedSums {
  double inverse[kMostPieces][kMostPieces];  // of the system of groups
  double corrections[kMostPieces + 1];       // of groups, and zero of held rows
  double pivots[kMostPieces], column[kMostPieces], least[kMostPieces];  // inverting
  double slices[kSystemSums][kMostPieces];                              // of this block's slices
  double coarse[kWarps][kMostPieces];                                   // of what a warp is at
};

/// What a block keeps of its rows and their entries.
struct BlockStore {
  double *x, *b, *residual, *diagonal, *inverse, *direction, *product;  // [rows of the block]
  double* couplings;                                                    // [their entries]
  std::uint32_t* columns;                                               // with tags

  __device__ BlockStore(unsigned char* memory, Index rows, Index entries)
      : x(reinterpret_cast<double*>(memory)),
        b(x + rows),
        residual(b + rows),
        diagonal(residual + rows),
        inverse(diagonal + rows),
        direction(inverse + rows),
        product(direction + rows),
        couplings(product + rows),
        columns(reinterpret_cast<std::uint32_t*>(couplings + entries)) {}
};

/// All threads of the cluster; what they wrote before is then seen.
__device__ inline void meet_all() {
#if defined(PBDSURG_CUDA_HAS_CLUSTERS)
  meet_cluster();
#else
  __syncthreads();  // of the one block
#endif
}

/// Where the share `of` of `parts` begins.
__device__ inline Index part(Index count, unsigned of, unsigned parts) {
  return static_cast<Index>(static_cast<unsigned>(count) * of / parts);
}

/// Of all blocks.
__device__ inline Index thread_count() {
  return static_cast<Index>(gridDim.x) * kSystemThreads;
}
__device__ inline Index thread_of_all() {
  return static_cast<Index>(blockIdx.x * kSystemThreads + threadIdx.x);
}

/// The same bits in each of `lanes` neighbours, for one adds to another as that to the one.
template <int kLanes = kWarp>
__device__ inline double sum_lanes(double value) {
#pragma unroll
  for (int other = kLanes / 2; other > 0; other /= 2) {
    value += __shfl_xor_sync(kAllLanes, value, other);
  }
  return value;
}

}  // namespace
}  // namespace pbdsurg::cuda
