// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that tools' surfaces touch and nothing else holds, one after another: they move
/// rigidly to where their contacts balance, see touched_pieces.h. One block a copy.

#include <limits>

#include <cub/block/block_scan.cuh>

#include "cuda/solver/coarse_kernels.cuh"
#include "cuda/solver/momentum_kernels.cuh"
#include "cuda/solver/surface_answer_kernels.cuh"
#include "cuda/solver/surface_projection_kernels.cuh"
#include "lib/solver/methods/piece_easing.h"
#include "lib/solver/methods/rigid_balance.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr Index kNoPiece = std::numeric_limits<Index>::max();

/// The first of the pieces that move with the one at a place.
__device__ inline Index piece_at(const FreePieceArrays& pieces, const SurfaceArrays& surfaces,
                                 Index place) {
  return group_of(pieces, __ldg(surfaces.piece_of_place + place));
}

__device__ inline Index piece_of(const FreePieceArrays& pieces, const SurfaceArrays& surfaces,
                                 Index contact) {
  return piece_at(pieces, surfaces, surfaces.contacts[contact].contact.feature.places[0]);
}

/// The first piece behind another that contacts touch, or kNoPiece.
__device__ inline Index next_touched(const FreePieceArrays& pieces, const SurfaceArrays& surfaces,
                                     Index count, Index piece) {
  __shared__ Index least;
  __syncthreads();
  if (threadIdx.x == 0) {
    least = kNoPiece;
  }
  __syncthreads();
  for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kMomentumSums) {
    const Index own = piece_of(pieces, surfaces, c);
    if (own > piece) {
      atomicMin(&least, own);
    }
  }
  __syncthreads();
  return least;
}

/// Whether tools hold a piece, or push it with vertices alone.
__device__ inline bool is_held(const FreePieceArrays& pieces, const ToolArrays& tools,
                               StepInput* input, Index piece) {
  const SurfaceArrays& surfaces = tools.surfaces;
  bool is_any = false;
  const HeldInput* const held = table<HeldInput>(input, input->held);
  for (Index h = static_cast<Index>(threadIdx.x); h < input->held_count; h += kMomentumSums) {
    is_any |= piece_at(pieces, surfaces, held[h].place) == piece;
  }
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    const Index* const places = tools.contact_places + of_pusher(pusher, tools.contact_room);
    for (Index i = static_cast<Index>(threadIdx.x); i < tools.contact_counts[pusher];
         i += kMomentumSums) {
      is_any |= piece_at(pieces, surfaces, places[i]) == piece;
    }
  }
  return __syncthreads_or(is_any) != 0;
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

/// Shared memory for sums.
struct SumRoom {
  alignas(16) unsigned char bytes[kMomentumSums * sizeof(MomentumSums)];

  template <class Sums>
  __device__ Sums* of() {
    static_assert(sizeof(Sums) <= sizeof(MomentumSums));
    return reinterpret_cast<Sums*>(bytes);
  }
};

/// Where the weighted corners of a contact are, in what arm_at(place) says of them.
template <class ArmAt>
__device__ Vec3<double> arm_of_contact(const SurfaceContact& contact, const ArmAt& arm_at) {
  Vec3<double> sum{0, 0, 0};
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + static_cast<double>(contact.weights[k]) * arm_at(contact.feature.places[k]);
  }
  return sum;
}

/// Lists the contacts of a piece, in their order.
/// @return  how many
__device__ inline Index list_rigid_contacts(const DeviceState& state, const FreePieceArrays& pieces,
                                            const SurfaceArrays& surfaces, Index count, Index piece,
                                            const Vec3<double>& centre, float inverse_dt_squared) {
  using Scan = cub::BlockScan<Index, kMomentumSums>;
  __shared__ typename Scan::TempStorage storage;
  Index listed = 0;
  for (Index first = 0; first < count; first += kMomentumSums) {
    const Index c = first + static_cast<Index>(threadIdx.x);
    bool is_of_piece = c < count && piece_of(pieces, surfaces, c) == piece;
    RigidContact rigid{};
    if (is_of_piece) {
      const SurfaceContact& contact = surfaces.contacts[c].contact;
      const ContactReading<float> now = read_contact(state, surfaces, surfaces.contacts[c]);
      is_of_piece = is_finite(now.gap) && is_finite_way(now.slip);
      const Vec3<double> arm =
          arm_of_contact(contact, [&](Index place) { return FlownVertex(state, place).arm; });
      rigid = {arm - centre,
               to_double(contact.normal),
               {now.gap, to_double(now.slip)},
               {contact.multiplier, to_double(contact.friction)},
               surfaces.contacts[c].friction,
               static_cast<double>(contact.stiffness) / inverse_dt_squared};
    }
    Index rank = 0, sum = 0;
    Scan(storage).ExclusiveSum(is_of_piece ? 1 : 0, rank, sum);
    if (is_of_piece) {
      surfaces.rigid[listed + rank] = rigid;
    }
    listed += sum;
    __syncthreads();
  }
  return listed;
}

__global__ void __launch_bounds__(kMomentumSums)
    balance_pieces(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input) {
  wait_for_previous();
  __shared__ SumRoom room;
  __shared__ SharedRoom<Screw> twist;
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const SurfaceArrays& surfaces = tools.surfaces;
  const Index count = contact_count(surfaces);
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index piece = next_touched(pieces, surfaces, count, kInvalidIndex); piece != kNoPiece;
       piece = next_touched(pieces, surfaces, count, piece)) {
    if (is_held(pieces, tools, input, piece)) {
      continue;
    }
    MomentumSums own;
    for_each_place(pieces, piece, [&](Index place) {
      const FlownVertex vertex(state, place);
      if (vertex.counts()) {
        own.add(1 / static_cast<double>(vertex.moved.w), vertex.arm,
                to_double(position_of(vertex.moved) - vertex.flight));
      }
    });
    const MomentumSums sums = total(own, room.of<MomentumSums>());
    if (!(sums.mass > 0)) {
      continue;
    }
    const Index listed = list_rigid_contacts(state, pieces, surfaces, count, piece, sums.centre(),
                                             input->substep.inverse_dt_squared);
    if (thread == 0) {
      twist.get() = RigidBalance(sums, surfaces.rigid, listed).twist();
    }
    __syncthreads();
    const RigidMove move{twist.get().linear, twist.get().angular, sums.centre()};
    for_each_place(pieces, piece, [&](Index place) {
      const FlownVertex vertex(state, place);
      const Vec3<float> way = part_of(move, vertex.arm);
      if (vertex.counts() && is_finite_way(position_of(vertex.moved) + way)) {
        displace(state, place, way);
      }
    });
    __syncthreads();
  }
}

void answer_surface_contacts(const DeviceState& state, const FreePieceArrays& pieces,
                             const ToolArrays& tools, StepInput* input, Index substep,
                             const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the balance of pieces", 1, kMomentumSums, balance_pieces, state, pieces,
           tools, input);
  }
  if (tools.surfaces.has_springs) {
    launch(how, "launching springs of tools", 1, kSpringThreads, balance_springs, state, tools,
           input);
  }
  launch(how, "launching the answer of surfaces", share_blocks(kAnswerBlocks, 1, how), kToolThreads,
         answer_surfaces, state, tools, input, substep);
}

/// A piece as it is eased.
__device__ inline void ease_piece(const DeviceState& state, const FreePieceArrays& pieces,
                                  const SurfaceArrays& surfaces, const StepInput* input,
                                  Index count, Index piece, SumRoom& room) {
  __shared__ SharedRoom<Pushes> shared_pushes;
  const auto thread = static_cast<Index>(threadIdx.x);
  const auto position = [&](Index place) {
    return to_double(position_of(load_particle(state.particles + place)));
  };
  MomentumSums own;
  for_each_place(pieces, piece, [&](Index place) {
    const FlownVertex vertex(state, place);
    if (vertex.counts()) {
      own.add(1 / static_cast<double>(vertex.moved.w), position(place), {0, 0, 0});
    }
  });
  const MomentumSums sums = total(own, room.of<MomentumSums>());
  if (thread == 0) {
    Pushes& pushes = shared_pushes.get();
    pushes = {sums};
    for (Index c = 0; c < count; ++c) {
      if (piece_of(pieces, surfaces, c) == piece) {
        const SurfaceContact& contact = surfaces.contacts[c].contact;
        pushes.add(contact.multiplier, contact.normal, arm_of_contact(contact, position));
      }
    }
  }
  __syncthreads();
  const Pushes pushes = shared_pushes.get();
  const RigidMove pushed = pushes.sums.rigid_move();
  EasingSums along;
  for_each_place(pieces, piece, [&](Index place) {
    const FlownVertex vertex(state, place);
    if (vertex.counts()) {
      along.add(1 / static_cast<double>(vertex.moved.w),
                to_double(part_of(pushed, position(place))),
                load_velocity(state.velocities + place), load_way(state.ways + place),
                load_velocity(state.velocities_before + place), input->h);
    }
  });
  const Easing easing = total(along, room.of<EasingSums>()).easing(pushes);
  for_each_place(pieces, piece, [&](Index place) {
    const FlownVertex vertex(state, place);
    if (vertex.counts()) {
      const Vec3<float> way = part_of(pushed, position(place));
      Velocity* const now = state.velocities + place;
      Velocity* const before = state.velocities_before + place;
      store_velocity(now, load_velocity(now) + static_cast<float>(easing.now) * way);
      store_velocity(before, load_velocity(before) + static_cast<float>(easing.before) * way);
    }
  });
  const float relief = relief_of(easing, input->h, input->per_step, input->density);
  for (Index c = thread; c < count; c += kMomentumSums) {
    if (piece_of(pieces, surfaces, c) == piece) {
      surfaces.contacts[c].contact.is_eased = true;
      surfaces.contacts[c].contact.relief = relief;
    }
  }
  __syncthreads();
}

__global__ void __launch_bounds__(kMomentumSums)
    ease_pieces(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input,
                Index substep) {
  wait_for_previous();
  __shared__ SumRoom room;
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const SurfaceArrays& surfaces = tools.surfaces;
  const Index count = contact_count(surfaces);
  for (Index piece = next_touched(pieces, surfaces, count, kInvalidIndex); piece != kNoPiece;
       piece = next_touched(pieces, surfaces, count, piece)) {
    if (!is_held(pieces, tools, input, piece)) {
      ease_piece(state, pieces, surfaces, input, count, piece, room);
    }
  }
  for (Index t = 0; t < input->tool_count; ++t) {
    const Index meeter = table<ToolInput>(input, input->tools)[t].meeter;
    if (meeter == kInvalidIndex) {
      continue;
    }
    const Index first = surfaces.ends[meeter];
    const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
      const SurfaceContact& contact = surfaces.contacts[first + i].contact;
      const float scale = contact.is_eased ? contact.relief : 0.0F;
      force = scale * (contact.multiplier * contact.normal);
      point = contact.point;
    };
    feel<kMomentumSums>(table<Wrench>(input, input->wrenches)[t],
                        origin_of(input, substep, t, surfaces, meeter),
                        surfaces.ends[meeter + 1] - first, at);
    __syncthreads();
  }
}

void ease_surface_contacts(const DeviceState& state, const FreePieceArrays& pieces,
                           const ToolArrays& tools, StepInput* input, Index substep,
                           const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the easing of pieces", 1, kMomentumSums, ease_pieces, state, pieces,
           tools, input, substep);
  }
  launch(how, "launching the easing of surfaces", 1, kProjectThreads, ease_surfaces, state, tools,
         input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
