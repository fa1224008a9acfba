// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The kernel that solves a local system: one launch of one cluster a solution.

#include <cstddef>
#include <cstdint>

#include <cuda_runtime_api.h>

#include "pbdsurg/base/types.h"

#include "lib/device/system_plan.h"

namespace pbdsurg::cuda {

/// Stays from one solution to the next, in the memory of the device.
struct SystemArrays {
  Index row_count, tet_count, piece_count, slices_per_piece;
  bool is_grouped;
  bool is_in_shared_memory;     // what blocks store
  std::size_t block_bytes;      // what a block stores
  const Index* pieces;          // [piece_count + 1] first rows
  const Index* starts;          // [row_count + 1]
  const Index* columns;         // [entry_count]
  const Index* row_tet_starts;  // [row_count + 1]
  const RowTet* row_tets;       // [4 tet_count]
  const int4* corners;          // [tet_count] rows
  const double* conductances;   // [tet_count, 6]

  // scratch
  unsigned char* store;   // [block_count, block_bytes], unless in shared memory
  double* scales;         // [tet_count]
  double* tet_heat;       // [tet_count]
  double2* starting;      // [row_count] x; tag of the row
  double2* pairs;         // [row_count] residual over diagonal; direction
  double* coarse;         // [slice_count, kMostPieces]
  double* group_inverse;  // [kMostPieces, kMostPieces] kept
  double* sums;           // [kSystemSums, kMostPieces]
};

inline constexpr Index kSystemSums = 4;

/// Of one solution, in memory of the host that the device reads and writes.
struct SystemInput {
  const double* scales;  // [tet_count], or null: all 1
  const double* added;   // [row_count]
  const double* b;       // [row_count]
  const double* x;       // [row_count]
  double tolerance;
  int most_iterations;
  bool is_relative;     // see DeviceSolve
  bool inverts_groups;  // or takes the inverse of before
};

struct SystemResult {
  double squares, scale;  // of the residual, and of that of x = 0
  int iterations;
};

struct SystemOutput {
  double* x;         // [row_count]
  double* tet_heat;  // [tet_count], or null
  double* row_heat;  // [row_count], or null
  SystemResult* result;
};

/// What the current device can do.
struct SystemLimits {
  Index most_blocks;         // of a cluster
  std::size_t shared_bytes;  // that a block may store
};

/// @throws DeviceError  if the program has no code for the device
[[nodiscard]] SystemLimits prepare_system_kernel();

void solve_system(const SystemArrays& arrays, const SystemInput& input, const SystemOutput& output,
                  Index block_count, cudaStream_t stream);

}  // namespace pbdsurg::cuda
