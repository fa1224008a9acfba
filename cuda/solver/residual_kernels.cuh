// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Forces that sweeps have left out of balance at vertices, of a coarse correction: by rows, or by
/// tiles.

#include <cstddef>

#include "cuda/solver/cooperative_kernels.cuh"
#include "cuda/solver/counted_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tile_kernels.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/device/device_arrays.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_moves.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

__device__ inline CoarseArrays of_copy(CoarseArrays coarse) {
  const std::size_t copy = copy_index();
  const std::size_t vertices = copy * static_cast<std::size_t>(coarse.vertex_room);
  const std::size_t nodes = copy * static_cast<std::size_t>(coarse.node_count);
  const std::size_t modes = copy * static_cast<std::size_t>(coarse.mode_count);
  coarse.residuals += vertices;
  coarse.moves += vertices;
  coarse.part_sums += nodes * static_cast<std::size_t>(coarse.part_room);
  coarse.part_gains += nodes * static_cast<std::size_t>(coarse.part_room);
  coarse.sums += nodes;
  coarse.moves_of_nodes += nodes;
  coarse.gains_before += nodes;
  coarse.turns += nodes;
  coarse.amplitudes += modes;
  coarse.hold_modes += modes * kHoldRows;
  coarse.hold_sums += nodes * static_cast<std::size_t>(coarse.node_count);
  coarse.hold_counts += nodes;
  coarse.hold_parts += copy * kMostModeParts * HoldSystem::entries(kHoldRows);
  coarse.holds += copy;
  coarse.wide_sums += nodes * static_cast<std::size_t>(coarse.wide_count);
  coarse.wide_compliances += copy * static_cast<std::size_t>(coarse.wide_count);
  return coarse;
}

/// Of w of residuals: the vertex stays, as a tool holds it, or as a correction knows nothing of
/// what does.
constexpr float kHeld = -1;

/// What is out of balance at a vertex, to where sums find it.
/// @param force  N, of its rows
__device__ inline void store_residual(const DeviceState& state, const CoarseArrays& coarse,
                                      float inverse_dt_squared, ParticleOffset corner,
                                      const FixedPoint& point, const Vec3<float>& force,
                                      bool is_held) {
  const Particle p = load_particle(&at(state.displacements, corner));
  const Vec3<float> flight = position_of(load_particle(&at(state.flights, corner)));
  const Vec3<float> residual = (inverse_dt_squared / p.w) * (flight - position_of(p)) + force;
  const bool counts = p.w > 0 && !is_held && !is_lost(point) && is_finite_way(residual);
  store_particle(&at(coarse.residuals, corner), counts ? residual : Vec3<float>{},
                 counts    ? 1.0F
                 : is_held ? kHeld
                           : 0.0F);
}

/// By rows; threads of a vertex as in move_blocks().
/// @tparam kRare  see load_ranges()
template <int kParts, bool kRare>
__global__ void __launch_bounds__(kBlockThreads)
    find_residuals_of_blocks(DeviceState state, VertexArrays vertices, CoarseArrays coarse,
                             const StepInput* input, bool has_tools) {
  const Index vertex = thread_index() / kParts;
  const Index part = thread_index() % kParts;
  const Index index = vertex / kBlockLanes;
  const Index lane = vertex % kBlockLanes;
  VertexBlock block{};
  ParticleOffset corner = 0;
  if (index < vertices.block_count) {  // no kernel of this step writes them
    block = load_ranges<kRare>(vertices.blocks + index);
    corner = __ldg(vertices.blocks[index].corners + lane);
  }
  vertices = of_copy(vertices);
  wait_for_previous();
  if (lane >= block.lane_count) {
    return;
  }
  state = of_copy(state);
  const FixedPoint point = without_count(load_counted(&at(state.fixed_points, corner)));
  const VertexRows rows = rows_of(vertices);
  VertexForce<float> sum;
  add_rows(rows, block, WaitingLane{state.fixed_points, point, lane}, sum, {part, kParts});
  add_up<kParts>(sum, mask_of_parts<kParts>());
  if (part == 0) {
    const bool is_held =
        has_tools && __ldcg(vertices.holds + index * kBlockLanes + lane) != kInvalidIndex;
    store_residual(state, of_copy(coarse), input[copy_index()].substep.inverse_dt_squared, corner,
                   point, sum.force, is_held);
  }
}

/// By tiles, each a warp's, as in sweep_tiles(); nobody moves, so nobody waits.
/// @tparam kRare  see load_ranges()
template <int kParts, bool kRare>
__global__ void __launch_bounds__(kBlockThreads)
    find_residuals_of_tiles(DeviceState state, VertexArrays vertices, TileArrays tiles,
                            CoarseArrays coarse, StepInput* input, bool has_tools) {
  using Shape = TileShape<kParts>;
  constexpr Index kFirstCount = 0;  // that all points have
  extern __shared__ float4 all_ways[];
  const Index of_warp = static_cast<Index>(threadIdx.x) % kTileThreads;
  const Index tile_index = thread_index() / kTileThreads;
  const Index index = tile_index / Shape::kTiles;
  const Index thread = tile_index % Shape::kTiles * kTileThreads + of_warp;
  NextTile<kParts> tile;
  if (index < vertices.block_count) {  // no kernel of this step writes them
    tile.load_block(tiles, index);
    tile.load_names(tiles, thread);
  }
  wait_for_previous();
  if (index >= vertices.block_count) {
    return;
  }
  state = of_copy(state);
  tiles = of_copy(tiles, vertices);
  vertices = of_copy(vertices);
  input += copy_index();
  const Ways ways(all_ways + static_cast<Index>(threadIdx.x) / kParts *
                                 ways_room(kParts, tiles.most_neighbors));
  const FixedPoint* const points = state.fixed_points;
  FixedPoint met[Shape::kNeighbors];
#pragma unroll
  for (int k = 0; k < Shape::kNeighbors; ++k) {
    met[k] = load_neighbor(points, tile.names[k]);
  }
  const ParticleOffset corner = tile.own & ~kNeighborFlags;
  const FixedPoint own = without_count(load_counted(&at(points, corner)));
  UsualRows<kParts> usual;
  usual.load(tiles.pulls + first_record(tile.firsts.y, thread),
             tiles.volumes + first_record(tile.firsts.w, thread));
  wait_for<kParts>(points, tile.names, kFirstCount, met, own, 1 + of_warp % kParts, ways, input);
  wait_for_more<kParts>(points, tiles, tile, kFirstCount, index, thread, own, ways, input);
  __syncwarp();
  const Index lane = thread / kParts;
  const VertexRows rows = rows_of(vertices);
  VertexForce<float> sum;
  add_tile<kParts, kRare>(usual, tiles, tile, rows, index, thread, ways,
                          WaitingLane{points, own, lane}, sum);
  add_up<kParts>(sum, ~0U);
  if (of_warp % kParts == 0 && (tile.own & kIsIdle) == 0) {
    const bool is_held =
        has_tools && __ldcg(vertices.holds + index * kBlockLanes + lane) != kInvalidIndex;
    store_residual(state, of_copy(coarse), input->substep.inverse_dt_squared, corner, own,
                   sum.force, is_held);
  }
}

template <bool kRare>
constexpr auto* residual_kernel(Index parts) {
  return parts == 16  ? find_residuals_of_tiles<16, kRare>
         : parts == 8 ? find_residuals_of_tiles<8, kRare>
                      : find_residuals_of_tiles<4, kRare>;
}

auto* residual_kernel(const TileArrays& tiles) {
  return tiles.has_rare_rows ? residual_kernel<true>(tiles.parts)
                             : residual_kernel<false>(tiles.parts);
}

void find_residuals(const DeviceState& state, const VertexArrays& vertices,
                    const CoarseArrays& coarse, const StepInput* input, bool has_tools,
                    const Launch& how) {
  launch(how, "launching what finds residuals",
         blocks_for(vertices.block_count * kBlockLanes * kVertexParts, kBlockThreads),
         kBlockThreads,
         vertices.has_rare_rows ? find_residuals_of_blocks<kVertexParts, true>
                                : find_residuals_of_blocks<kVertexParts, false>,
         state, vertices, coarse, input, has_tools);
}

Index prepare_residuals(const TileArrays& tiles) {
  return blocks_at_once(tiles, {residual_kernel(tiles)});
}

void find_residuals_by_tiles(const DeviceState& state, const VertexArrays& vertices,
                             const TileArrays& tiles, const CoarseArrays& coarse, StepInput* input,
                             bool has_tools, const Launch& how) {
  const Index threads = vertices.block_count * tiles_of_block(tiles.parts) * kTileThreads;
  launch_with_memory(how, "launching what finds residuals", blocks_for(threads, kBlockThreads),
                     kBlockThreads, shared_bytes(tiles), residual_kernel(tiles), state, vertices,
                     tiles, coarse, input, has_tools);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
