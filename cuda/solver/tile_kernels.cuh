// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Records of tiles, see VertexTiles, from the rows of the vertex-block method.

#include <cstddef>
#include <cstdint>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/device/vertex_tiles.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kPackThreads = 128;

__device__ inline TileArrays of_copy(TileArrays tiles, const VertexArrays& vertices) {
  if (vertices.is_damped) {
    const std::size_t threads = copy_index() * kTileThreads;
    tiles.springs += threads * static_cast<std::size_t>(tiles.spring_rows);
    tiles.volumes += threads * static_cast<std::size_t>(tiles.volume_rows);
  }
  return tiles;
}

/// Where the first record of a thread of a block is.
__device__ inline std::size_t first_record(Index first_row, Index thread) {
  return static_cast<std::size_t>(first_row) * kTileThreads + static_cast<std::size_t>(thread);
}

/// The records of a block, a block of threads each.
/// @param which  [block of threads] blocks; null for all
template <bool kNumbersOnly>
__global__ void __launch_bounds__(kPackThreads)
    pack_block(VertexArrays vertices, TileArrays tiles, const Index* which) {
  wait_for_previous();
  tiles = of_copy(tiles, vertices);
  vertices = of_copy(vertices);
  if (!vertices.is_damped && copy_index() > 0) {
    return;
  }
  const Index parts = tiles.parts;
  const Index index = which == nullptr ? static_cast<Index>(blockIdx.x) : which[blockIdx.x];
  const VertexBlock block = load_ranges<false>(vertices.blocks + index);
  const TileBlock* const to = tiles.blocks + index;
  const TileCounts counts = to->counts;
  const Index neighbor_count = counts.neighbors * parts;
  // of rows that are there, and of those that threads have beyond
  const auto for_each = [&](Index rows_of_thread, Index first_row, const auto& visit) {
    for (auto i = static_cast<Index>(threadIdx.x); i < kBlockLanes * rows_of_thread * parts;
         i += kPackThreads) {
      const Index lane = i % kBlockLanes;
      const Index row = i / kBlockLanes;
      const std::size_t record =
          first_record(first_row, (row / parts) * kBlockLanes * parts + lane * parts + row % parts);
      visit(lane, row, record);
    }
  };
  const auto position_of = [&](Index lane, ParticleOffset corner) -> std::uint32_t {
    for (Index i = 0; i < neighbor_count; ++i) {
      const std::size_t at = first_record(
          to->neighbors, (1 + i / parts) * kBlockLanes * parts + lane * parts + i % parts);
      if ((__ldg(tiles.neighbors + at) & ~kNeighborFlags) == corner) {
        return static_cast<std::uint32_t>(1 + i);
      }
    }
    return 0;
  };
  if constexpr (!kNumbersOnly) {
    if (copy_index() == 0) {
      for_each(counts.pulls, to->pulls, [&](Index lane, Index i, std::size_t record) {
        const bool is_there = lane < block.lane_count && i < block.pulls.count;
        const PullRow& row = vertices.pulls[block.pulls.first + i];
        tiles.pulls[record] =
            is_there ? PullRecord{row.weights[lane], position_of(lane, row.neighbors[lane])}
                     : PullRecord{};
      });
    }
  }
  for_each(counts.springs, to->springs, [&](Index lane, Index i, std::size_t record) {
    const bool is_there = lane < block.lane_count && i < block.springs.count;
    const SpringRow& row = vertices.springs[block.springs.first + i];
    SpringRecord& spring = tiles.springs[record];
    spring.stiffness = is_there ? __ldcg(row.stiffness + lane) : 0.0F;
    spring.rest = is_there ? __ldcg(row.rest + lane) : 0.0F;
    if constexpr (!kNumbersOnly) {
      spring.neighbor = is_there ? position_of(lane, row.neighbors[lane]) : 0U;
    }
  });
  for_each(counts.volumes, to->volumes, [&](Index lane, Index i, std::size_t record) {
    const bool is_there = lane < block.lane_count && i < block.volumes.count;
    const VolumeRow& row = vertices.volumes[block.volumes.first + i];
    VolumeRecord& volume = tiles.volumes[record];
    volume.stiffness = is_there ? __ldcg(row.stiffness + lane) : 0.0F;
    volume.target = is_there ? __ldcg(row.target + lane) : 0.0F;
    if constexpr (!kNumbersOnly) {
      volume.face = is_there ? position_of(lane, row.face[0][lane]) |
                                   position_of(lane, row.face[1][lane]) << 8 |
                                   position_of(lane, row.face[2][lane]) << 16
                             : 0U;
    }
  });
}

void pack_rows(const VertexArrays& vertices, const TileArrays& tiles, const Index* which,
               Index count, const Launch& how) {
  launch(how, "launching the packing of rows", count, kPackThreads, pack_block<false>, vertices,
         tiles, which);
}

void pack_numbers(const VertexArrays& vertices, const TileArrays& tiles, const Launch& how) {
  const Index* const all = nullptr;
  launch(how, "launching the packing of numbers", vertices.block_count, kPackThreads,
         pack_block<true>, vertices, tiles, all);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
