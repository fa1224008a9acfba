// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All substeps of an explicit step in one kernel, while no tool touches or holds anything. As in
/// cooperative_kernels.cuh, a vertex waits for its neighbours and for nothing else. It reads them
/// where they are at the start of its substep, and writes where it is at the end into the other
/// mailbox. To go through a substep is one move.

#include <cstddef>

#include "cuda/solver/cooperative_kernels.cuh"
#include "cuda/solver/counted_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/report_kernels.cuh"
#include "cuda/solver/tile_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/solver/methods/displacement.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// A vertex as all threads that share it have it.
struct PushedVertex {
  BegunVertex begun;
  FixedPoint own;

  __device__ void load(const DeviceState& state, const FixedPoint* points, ParticleOffset corner) {
    begun.load(state, corner);
    own = without_count(load_counted(&at(points, corner)));
  }

  /// Goes to the end of the substep.
  /// @param motion  of all vertices
  /// @param force   N, of tissue
  __device__ void move(const DeviceState& state, const FreeMotion<float>& motion, Index place,
                       const Vec3<float>& force, float inverse_dt_squared, float unit) {
    const float w = begun.base.w;
    const FreeMotion<float> falling = falling_motion(state, motion, place);
    const FreeMotion<float> flying = flying_motion(state, falling, w, place);
    const Vec3<float> pushed = begun.flight(flying) + pushed_flight(force, w, inverse_dt_squared);
    // what no force moves stays where it begins, as in push_blocks()
    begun.end(falling, w > 0 && is_finite_way(pushed) ? pushed : begun.start(falling));
    own = fixed_point(position_of(begun.base), begun.rounding, unit);
  }
};

/// Blocks of threads on a multiprocessor at once: as many as hold an organ of some 6000 vertices on
/// a large device. With sixteen threads a vertex these have fewer rows each, and so room in fewer
/// registers.
__host__ __device__ constexpr int staying_blocks(int parts) {
  return parts >= 16 ? 14 : 12;
}

/// All substeps. Threads of a warp stay together.
/// @tparam kParts  as in sweep_tiles()
/// @tparam kStays  whether there is a warp for each tile, which then keeps it in its registers
/// @tparam kRare   see load_ranges()
template <int kParts, bool kStays, bool kRare>
__global__ void __launch_bounds__(kBlockThreads, kStays ? staying_blocks(kParts) : 1)
    push_tiles(DeviceState state, VertexArrays vertices, TileArrays tiles, Mailboxes boxes,
               StepInput* input) {
  using Shape = TileShape<kParts>;
  extern __shared__ float4 all_ways[];
  state = of_copy(state);
  boxes = of_copy(boxes, state.capacity);
  input += copy_index();
  const Index of_warp = static_cast<Index>(threadIdx.x) % kTileThreads;
  const Ways ways(all_ways + static_cast<Index>(threadIdx.x) / kParts *
                                 ways_room(kParts, tiles.most_neighbors));
  FreeMotion<float> motion = input->motion;
  float inverse_dt_squared = input->substep.inverse_dt_squared;
  const float unit = input->unit;
  const VertexRows rows = rows_of(vertices);
  VertexColors all{};
  all.count = 1;
  all.blocks[0] = {0, vertices.block_count};
  begin_step(state, vertices, *input, [](Index, BegunVertex&) {});
  const Index moves_before = input->moves_before;
  TileWalk<Shape::kTiles> walk(all, input->substep_count, thread_index() / kTileThreads,
                               thread_count() / kTileThreads);
  if (walk.is_done()) {
    return;
  }
  NextTile<kParts> next;
  next.load_block(tiles, walk.block());
  next.load_names(tiles, walk.tile() * kTileThreads + of_warp);
  UsualRows<kParts> usual;
  PushedVertex vertex;
  do {
    const NextTile<kParts> tile = next;
    const ParticleOffset corner = tile.own & ~kNeighborFlags;
    const Index substep = walk.sweep();
    if (substep == 1) {  // the first may begin with another kick
      motion = input->later_motion;
      inverse_dt_squared = input->later_substep.inverse_dt_squared;
    }
    const Index count = moves_before + substep;
    const bool is_even = (count & 1) == 0;  // which box the last step has left
    const FixedPoint* const points = boxes.points[is_even ? 0 : 1];
    FixedPoint* const next_points = boxes.points[is_even ? 1 : 0];
    FixedPoint met[Shape::kNeighbors];
#pragma unroll
    for (int k = 0; k < Shape::kNeighbors; ++k) {
      met[k] = load_neighbor(points, tile.names[k]);
    }
    const Index index = walk.block();
    const Index thread = walk.tile() * kTileThreads + of_warp;
    if (!kStays || substep == 0) {
      vertex.load(state, points, corner);
      usual.load(tiles.pulls + first_record(tile.firsts.y, thread),
                 tiles.volumes + first_record(tile.firsts.w, thread));
    }
    walk.advance();
    const bool is_last = walk.is_done();
    if (!kStays && !is_last) {
      next.load_block(tiles, walk.block());
    }

    wait_for<kParts>(points, tile.names, count, met, vertex.own, 1 + of_warp % kParts, ways, input);
    wait_for_more<kParts>(points, tiles, tile, count, index, thread, vertex.own, ways, input);
    __syncwarp();
    const WaitingLane access{points, vertex.own, thread / kParts};
    VertexForce<float> sum;
    add_tile<kParts, kRare>(usual, tiles, tile, rows, index, thread, ways, access, sum);
    if (!kStays && !is_last) {
      next.load_names(tiles, walk.tile() * kTileThreads + of_warp);
    }
    add_up<kParts>(sum, ~0U);
    if (is_lost(vertex.own)) {
      sum = {};
    } else if (__builtin_expect(!is_finite_way(sum.force), 0)) {
      sum.force = finite_force(rows, load_ranges<kRare>(vertices.blocks + index), access, sum);
    }
    vertex.move(state, motion, place_at(corner), sum.force, inverse_dt_squared, unit);
    if (of_warp % kParts == 0 && (tile.own & kIsIdle) == 0) {
      store_counted(&at(next_points, corner), vertex.own, count + 1);
      if (!kStays || is_last) {
        vertex.begun.store(state, corner);
      }
    }
    __syncwarp();
  } while (!walk.is_done());
}

template <bool kRare, int kParts>
constexpr auto* push_kernel(bool stays) {
  return stays ? push_tiles<kParts, true, kRare> : push_tiles<kParts, false, kRare>;
}

template <bool kRare>
constexpr auto* push_kernel(Index parts, bool stays) {
  return parts == 16  ? push_kernel<kRare, 16>(stays)
         : parts == 8 ? push_kernel<kRare, 8>(stays)
                      : push_kernel<kRare, 4>(stays);
}

auto* push_kernel(const TileArrays& tiles, bool stays) {
  return tiles.has_rare_rows ? push_kernel<true>(tiles.parts, stays)
                             : push_kernel<false>(tiles.parts, stays);
}

Index prepare_explicit_step(const TileArrays& tiles) {
  return blocks_at_once(tiles, {push_kernel(tiles, false), push_kernel(tiles, true)});
}

void step_explicitly(const ExplicitSubsteps& substeps, const DeviceState& state,
                     const VertexArrays& vertices, const TileArrays& tiles, const Mailboxes& boxes,
                     StepInput* input, const Launch& how) {
  launch_at_once(how, "launching explicit substeps", substeps.block_count, tiles,
                 push_kernel(tiles, substeps.stays), state, vertices, tiles, boxes, input);
}

/// Where vertices are heading for: see HeadingAccess.
struct DeviceHeading {
  const Particle* bases;
  const Velocity* velocities;
  Vec3<float> own_base;
  float time;  ///< s
  Index lane;

  [[nodiscard]] __device__ float load(const float* numbers) const { return __ldg(numbers + lane); }
  [[nodiscard]] __device__ Heading<float> position(const ParticleOffset* corners) const {
    const ParticleOffset corner = __ldg(corners + lane);
    return {position_of(load_particle(&at(bases, corner))) - own_base,
            time * load_velocity(&at(velocities, corner))};
  }
};

/// As stiffest_vertex().
template <int kParts>
__global__ void __launch_bounds__(kBlockThreads)
    find_stiffest(DeviceState state, VertexArrays vertices, StepInput* input) {
  const Index vertex = thread_index() / kParts;
  const Index index = vertex / kBlockLanes;
  const Index lane = vertex % kBlockLanes;
  float square = 0;
  wait_for_previous();
  if (index < vertices.block_count) {
    state = of_copy(state);
    VertexBlock block = load_ranges<false>(vertices.blocks + index);
    const ParticleOffset corner = __ldg(vertices.blocks[index].corners + lane);
    if (lane >= block.lane_count) {
      block = {};  // rows of idle lanes may name vertices that are gone
    }
    const Vec3<float> base = position_of(load_particle(&at(state.particles, corner)));
    const float share = __ldg(vertices.stiffness_shares + index * kBlockLanes + lane);
    const DeviceHeading access{state.particles, state.velocities, base, input->heading, lane};
    const VertexRows rows = rows_of(vertices);
    VolumeStiffness<float> stiffness;
    add_rows(rows, block, access, stiffness, {thread_index() % kParts, kParts});
#pragma unroll
    for (int distance = kParts / 2; distance > 0; distance /= 2) {
      stiffness.ahead += __shfl_xor_sync(mask_of_parts<kParts>(), stiffness.ahead, distance);
      stiffness.back += __shfl_xor_sync(mask_of_parts<kParts>(), stiffness.back, distance);
    }
    square = stiffness.most(share, 0.0F);  // nor what is no number
  }
  const Index most = over_warp([](Index a, Index b) { return a < b ? b : a; },
                               __float_as_int(square));  // ordered as the floats are
  if (threadIdx.x % kWarp == 0 && most > 0) {
    atomicMax(&input[copy_index()].sums.stiffest, static_cast<std::uint32_t>(most));
  }
}

void measure_stiffness(const DeviceState& state, const VertexArrays& vertices, StepInput* input,
                       const Launch& how) {
  launch(how, "launching a measure of stiffness",
         blocks_for(vertices.block_count * kBlockLanes * kVertexParts, kBlockThreads),
         kBlockThreads, find_stiffest<kVertexParts>, state, vertices, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
