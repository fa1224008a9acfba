// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The plain kernels around the colouring programs: one thread an item.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <cuda_runtime_api.h>

#include "pbdsurg/base/types.h"

#include "cuda/check.cuh"
#include "cuda/coloring/grid_team.cuh"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/constraint_order.h"
#include "lib/coloring/disc_palette.h"
#include "lib/coloring/repair_program.h"

namespace pbdsurg::cuda {

inline constexpr int kBlock = 256;  // threads

/// Colours up to which sizes are counted in shared memory.
inline constexpr Index kSharedColors = 8 * 1024;

__device__ inline Index thread_index() {
  return static_cast<Index>(blockIdx.x * blockDim.x + threadIdx.x);
}

/// Launches kernel(size, arguments...) with one thread an item.
template <class... Parameters, class... Arguments>
void launch(void (*kernel)(Index, Parameters...), Index size, cudaStream_t stream,
            const Arguments&... arguments) {
  if (size > 0) {
    const auto blocks = (static_cast<unsigned>(size) + kBlock - 1) / kBlock;
    kernel<<<blocks, kBlock, 0, stream>>>(size, arguments...);
    PBDSURG_CUDA_CHECK(cudaGetLastError());
  }
}

static __global__ void count_valences(Index entry_count, const Index* vertices, Index* valences) {
  const Index i = thread_index();
  if (i < entry_count) {
    atomicAdd(&valences[vertices[i]], 1);
  }
}

/// Which constraint names each entry.
template <class Access>
__global__ void list_owners(Index count, Access constraints, Index* owners) {
  const Index c = thread_index();
  if (c < count) {
    const Index first = constraints.first_entry(c);
    const Index size = constraints[c].size();
    for (Index i = 0; i < size; ++i) {
      owners[first + i] = c;
    }
  }
}

/// Sorting by these brings the entries of a vertex together, those of smaller rank first.
static __global__ void make_rank_keys(Index entry_count, const Index* vertices, const Index* owners,
                                      const std::uint32_t* ranks, std::uint64_t* keys) {
  const Index i = thread_index();
  if (i < entry_count) {
    keys[i] = (static_cast<std::uint64_t>(vertices[i]) << 32) | ranks[owners[i]];
  }
}

template <class Access>
__global__ void make_valence_keys(Index count, Access constraints, const Index* valences,
                                  std::uint64_t* keys, Index* ids) {
  const Index c = thread_index();
  if (c < count) {
    keys[c] = valence_key(constraints[c], valences);
    ids[c] = c;
  }
}

static __global__ void invert_order(Index count, const Index* order, std::uint32_t* ranks) {
  const Index i = thread_index();
  if (i < count) {
    ranks[order[i]] = static_cast<std::uint32_t>(i);
  }
}

static __global__ void shuffle_ranks(Index count, int bits, std::uint64_t salt,
                                     std::uint32_t* ranks) {
  const Index c = thread_index();
  if (c < count) {
    ranks[c] = shuffled_rank(static_cast<std::uint32_t>(c), bits, salt);
  }
}

template <class Access>
__global__ void make_palettes(Index count, Access constraints, const Index* offsets,
                              const Index* entries, double shrink, Index* palettes) {
  const Index c = thread_index();
  if (c < count) {
    palettes[c] = palette_for(count_conflicts(constraints, c, offsets, entries), shrink);
  }
}

/// Lists whoever has no colour, in any order.
static __global__ void list_uncolored(Index count, const Index* colors, Index* list,
                                      Index* list_count) {
  const Index c = thread_index();
  if (c < count && colors[c] == kInvalidIndex) {
    list[atomicAdd(list_count, 1)] = c;
  }
}

template <class Access>
__global__ void fill_masks(Index count, Access constraints, const Index* colors, ColorMasks masks) {
  const Index c = thread_index();
  if (c < count && colors[c] >= 0) {
    for (const Index v : constraints[c]) {
      GridTeam::fetch_or(masks.word(v, colors[c] >> 6), std::uint64_t{1} << (colors[c] & 63));
    }
  }
}

template <class Access>
__global__ void fill_holders(Index count, Access constraints, const Index* colors,
                             ColorHolders holders) {
  const Index c = thread_index();
  if (c < count && colors[c] >= 0) {
    for (const Index v : constraints[c]) {
      holders.at(v, colors[c]) = c;
    }
  }
}

static __global__ void renumber_colors(Index count, const Index* numbers, Index* colors) {
  const Index c = thread_index();
  if (c < count && colors[c] >= 0) {
    colors[c] = numbers[colors[c]];
  }
}

static __global__ void overflow_colors(Index count, Index limit, Index* colors) {
  const Index c = thread_index();
  if (c < count && colors[c] >= limit) {
    colors[c] = kInvalidIndex;
  }
}

/// Counts each colour; uncoloured constraints are left out. With size_count entries of dynamic
/// shared memory up to kSharedColors.
static __global__ void count_colors(Index count, const Index* colors, Index* sizes,
                                    Index size_count) {
  extern __shared__ Index block_sizes[];
  const bool in_block = size_count <= kSharedColors;
  if (in_block) {
    for (Index i = static_cast<Index>(threadIdx.x); i < size_count; i += kBlock) {
      block_sizes[i] = 0;
    }
    __syncthreads();
  }
  for (Index c = thread_index(); c < count; c += static_cast<Index>(gridDim.x) * kBlock) {
    if (colors[c] >= 0) {
      atomicAdd(in_block ? &block_sizes[colors[c]] : &sizes[colors[c]], 1);
    }
  }
  if (in_block) {
    __syncthreads();
    for (Index i = static_cast<Index>(threadIdx.x); i < size_count; i += kBlock) {
      if (block_sizes[i] != 0) {
        atomicAdd(&sizes[i], block_sizes[i]);
      }
    }
  }
}

}  // namespace pbdsurg::cuda
