// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The momentum of free pieces after the sweeps of a substep: a block a piece, or a group of them.

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/surface_contact.cuh"
#include "lib/solver/methods/momentum.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// A vertex as keep_momentum() reads it.
struct FlownVertex {
  Particle moved;
  Vec3<float> base, flight;
  Vec3<double> arm;

  __device__ FlownVertex(const DeviceState& state, Index place)
      : moved(load_particle(state.displacements + place)),
        base(position_of(load_particle(state.particles + place))),
        flight(position_of(load_particle(state.flights + place))),
        arm(arm_of(base, position_of(moved), state.ways != nullptr)) {}

  [[nodiscard]] __device__ bool counts() const {
    return keeps_momentum(moved.w, base, position_of(moved), flight);
  }
};

__device__ inline FreePieceArrays of_copy(FreePieceArrays pieces) {
  const std::size_t first = copy_index() * static_cast<std::size_t>(pieces.count);
  pieces.groups += pieces.groups != nullptr ? first : 0;
  pieces.meeting += pieces.meeting != nullptr ? first : 0;
  pieces.touched += first;
  pieces.sums += first;
  return pieces;
}

/// The piece whose block has the vertices of one: the first of its group. kInvalidIndex: none, as
/// it is pushed from outside; see pushed_pieces.h.
__device__ inline Index group_of(const FreePieceArrays& pieces, Index piece) {
  return pieces.groups == nullptr || piece == kInvalidIndex ? piece : __ldcg(pieces.groups + piece);
}

/// Calls visit(place) for all places of a group, by kMomentumSums threads that take turns.
/// @param first  piece of the group
template <class Visit>
__device__ void for_each_place(const FreePieceArrays& pieces, Index first, const Visit& visit) {
  const Index end = pieces.groups == nullptr ? first + 1 : pieces.count;
  Index passed = 0;
  for (Index piece = first; piece < end; ++piece) {
    if (piece != first && group_of(pieces, piece) != first) {
      continue;
    }
    const Index start = __ldg(pieces.firsts + piece);
    const Index count = __ldg(pieces.firsts + piece + 1) - start;
    const Index turn =
        (static_cast<Index>(threadIdx.x) + kMomentumSums - passed % kMomentumSums) % kMomentumSums;
    for (Index i = turn; i < count; i += kMomentumSums) {
      visit(__ldg(pieces.places + start + i));
    }
    passed += count;
  }
}

/// The total of what each thread has, as momentum.h says.
/// @param room  [kMomentumSums]
template <class Sums>
__device__ Sums total(const Sums& own, Sums* room) {
  const auto thread = static_cast<Index>(threadIdx.x);
  __syncthreads();
  room[thread] = own;
  for (Index half = kMomentumSums / 2; half > 0; half /= 2) {
    __syncthreads();
    if (thread < half) {
      room[thread].add(room[thread + half]);
    }
  }
  __syncthreads();
  return room[0];
}

/// @param has_tools  whether any touch or hold something: then VertexArrays::holds are of now
__global__ void __launch_bounds__(kMomentumSums)
    keep_momenta(DeviceState state, VertexArrays vertices, FreePieceArrays pieces, ToolArrays tools,
                 bool has_tools) {
  __shared__ alignas(16) unsigned char memory[kMomentumSums * sizeof(MomentumSums)];
  MomentumSums* const sums = reinterpret_cast<MomentumSums*>(memory);
  wait_for_previous();
  const Index state_room = state.capacity;
  state = of_copy(state);
  const Index* const holds =
      vertices.holds + copy_index() * static_cast<std::size_t>(vertices.block_room * kBlockLanes);
  const auto piece = static_cast<Index>(blockIdx.x);
  pieces = of_copy(pieces);
  if (pieces.meeting != nullptr) {
    pieces.groups = pieces.meeting;
    tools.surfaces = of_copy(tools.surfaces, state_room);
  }
  if (__ldg(pieces.firsts + piece) == __ldg(pieces.firsts + piece + 1) ||
      group_of(pieces, piece) != piece) {
    return;
  }
  MomentumSums sum;
  bool is_held = false;
  for_each_place(pieces, piece, [&](Index place) {
    const FlownVertex vertex(state, place);
    if (vertex.counts()) {
      sum.add(1 / static_cast<double>(vertex.moved.w), vertex.arm,
              to_double(position_of(vertex.moved) - vertex.flight));
    }
    const Index lane = has_tools ? __ldg(vertices.lane_of_place + place) : kInvalidIndex;
    const Index hold = lane != kInvalidIndex ? __ldcg(holds + lane) : kInvalidIndex;
    // what other bodies do takes no momentum from it
    is_held =
        is_held || (hold != kInvalidIndex && !(pieces.meeting != nullptr && hold == kOnlySurfaces &&
                                               holds_of(tools.surfaces, place).count == 0));
  });
  if (__syncthreads_or(is_held) != 0) {
    return;
  }
  const RigidMove move = total(sum, sums).rigid_move();
  for_each_place(pieces, piece, [&](Index place) {
    const FlownVertex vertex(state, place);
    if (vertex.counts()) {
      store_particle(state.displacements + place,
                     position_of(vertex.moved) - part_of(move, vertex.arm), vertex.moved.w);
    }
  });
}

void keep_momentum(const DeviceState& state, const VertexArrays& vertices,
                   const FreePieceArrays& pieces, const ToolArrays& tools, bool has_tools,
                   const Launch& how) {
  launch(how, "launching what keeps momentum", pieces.count, kMomentumSums, keep_momenta, state,
         vertices, pieces, tools, has_tools);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
