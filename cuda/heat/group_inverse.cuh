// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The inverse of the small system of groups, by one block.

#include <cuda_runtime.h>

#include "cuda/heat/system_kernel.h"
#include "cuda/heat/system_memory.cuh"

namespace pbdsurg::cuda {
namespace {

// As LocalSystem.
constexpr double kLeastPivot = 1e-12;

/// Inverts the system of groups, as LocalSystem::invert_groups(); all threads of the block. The
/// first block leaves it for later solutions, too.
__device__ inline void invert_groups(const SystemArrays& arrays, SharedSums& shared) {
  const auto thread = static_cast<Index>(threadIdx.x);
  if (thread < arrays.piece_count) {
    shared.least[thread] = kLeastPivot * shared.inverse[thread][thread];
  }
  __syncthreads();
  for (Index k = 0; k < arrays.piece_count; ++k) {
    if (thread < arrays.piece_count) {
      const double pivot = shared.inverse[k][k];
      const double inverse = pivot > shared.least[k] ? 1 / pivot : 0;
      shared.pivots[thread] = inverse * (thread == k ? 1 : shared.inverse[k][thread]);
      shared.column[thread] = shared.inverse[thread][k];
    }
    __syncthreads();
    for (int i = thread; i < kMostPieces * kMostPieces; i += kSystemThreads) {
      const Index row = i / kMostPieces;
      const Index column = i % kMostPieces;
      if (row < arrays.piece_count && column < arrays.piece_count) {
        double& value = shared.inverse[row][column];
        value = row == k ? shared.pivots[column]
                         : (column == k ? 0 : value) - shared.column[row] * shared.pivots[column];
      }
    }
    __syncthreads();
  }
  if (blockIdx.x == 0) {
    for (int i = thread; i < kMostPieces * kMostPieces; i += kSystemThreads) {
      arrays.group_inverse[i] = shared.inverse[i / kMostPieces][i % kMostPieces];
    }
  }
}

}  // namespace
}  // namespace pbdsurg::cuda
