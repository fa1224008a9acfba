// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Touched pieces move rigidly to where their contacts balance, those that touch each other at
/// once; see touched_pieces.h.

#include <cub/block/block_scan.cuh>

#include "cuda/solver/surface_answer_kernels.cuh"
#include "cuda/solver/touched_pieces.cuh"
#include "lib/solver/methods/group_balance.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// The pieces of a group as they are balanced.
struct BalancedGroup {
  Index pieces[GroupSpace::kMostPieces];  ///< ascending
  Index count;
  GroupSpace space;
};

/// Lists the contacts of a group, piece by piece: those with bodies, then those with surfaces.
class GroupList {
 public:
  __device__ GroupList(const DeviceState& state, const FreePieceArrays& pieces,
                       const ToolArrays& tools, const TouchedPieces& touched,
                       const BalancedGroup& group, float inverse_dt_squared)
      : state_(state),
        pieces_(pieces),
        tools_(tools),
        touched_(touched),
        group_(group),
        inverse_dt_squared_(inverse_dt_squared) {}

  /// All threads of the block call it.
  /// @return  how many there are
  __device__ Index list() {
    Index listed = 0;
    for (Index rank = 0; rank < group_.count; ++rank) {
      add(touched_.touch_count(), listed,
          [&](Index c, GroupContact& contact) { return make_touch(rank, c, contact); });
      add(touched_.surface_count(), listed,
          [&](Index c, GroupContact& contact) { return make_surface(rank, c, contact); });
    }
    return listed;
  }

 private:
  template <class Make>
  __device__ void add(Index count, Index& listed, const Make& make) const {
    using Scan = cub::BlockScan<Index, kMomentumSums>;
    __shared__ typename Scan::TempStorage storage;
    for (Index first = 0; first < count; first += kMomentumSums) {
      const Index c = first + static_cast<Index>(threadIdx.x);
      GroupContact contact{};
      const bool is_there = c < count && make(c, contact);
      Index rank = 0, sum = 0;
      Scan(storage).ExclusiveSum(is_there ? 1 : 0, rank, sum);
      if (is_there) {
        tools_.group_contacts[listed + rank] = contact;
      }
      listed += sum;
      __syncthreads();
    }
  }

  [[nodiscard]] __device__ auto arms() const {
    return [this](Index place) { return FlownVertex(state_, place).arm; };
  }
  [[nodiscard]] __device__ Vec3<double> centre(Index piece) const {
    return pieces_.sums[piece].centre();
  }

  [[nodiscard]] __device__ bool make_surface(Index rank, Index c, GroupContact& made) const {
    const Index piece = group_.pieces[rank];
    if (touched_.piece_of(c) != piece) {
      return false;
    }
    const DeviceContact& stored = tools_.surfaces.contacts[c];
    const SurfaceContact& contact = stored.contact;
    const ContactReading<float> now = read_contact(state_, tools_.surfaces, stored);
    made.contact = {arm_of_contact(contact, arms()) - centre(piece),
                    to_double(contact.normal),
                    {now.gap, to_double(now.slip)},
                    {contact.multiplier, to_double(contact.friction)},
                    stored.friction,
                    static_cast<double>(contact.stiffness) / inverse_dt_squared_};
    made.first = rank;
    return is_finite(now.gap) && is_finite_way(now.slip);
  }

  /// None that an earlier piece has.
  [[nodiscard]] __device__ bool make_touch(Index rank, Index c, GroupContact& made) const {
    const Index piece = group_.pieces[rank];
    const TissueTouch& touch = tools_.touches.contacts[c];
    const int side = touched_.side_of(touch, piece);
    if (side < 0) {
      return false;
    }
    const Index other = touched_.find(touch.place_on(1 - side));
    const bool is_pair =
        other != kInvalidIndex && touched_.group_of(other) == touched_.group_of(piece);
    if (is_pair && other < piece) {
      return false;
    }
    const ContactReading<float> now =
        read_plane(touch, sum_of_side(state_, touch, 0) + sum_of_side(state_, touch, 1));
    const double sign = side == 0 ? 1 : -1;
    made.contact = {arm_of_contact(touch, side, arms()) - centre(piece),
                    sign * to_double(touch.normal),
                    {now.gap, sign * to_double(now.slip)},
                    {touch.multiplier, sign * to_double(touch.friction)},
                    touch.mu,
                    static_cast<double>(touch.stiffness) / inverse_dt_squared_};
    made.first = rank;
    if (is_pair) {
      for (Index i = 0; i < group_.count; ++i) {
        made.second = group_.pieces[i] == other ? i : made.second;
      }
      made.other_arm = arm_of_contact(touch, 1 - side, arms()) - centre(other);
    }
    return is_finite(now.gap) && is_finite_way(now.slip);
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  const ToolArrays& tools_;
  const TouchedPieces& touched_;
  const BalancedGroup& group_;
  float inverse_dt_squared_;
};

__global__ void __launch_bounds__(kMomentumSums)
    balance_touched(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input) {
  wait_for_previous();
  __shared__ union {
    SumRoom sums;
    BalancedGroup group;
  } room;
  __shared__ SharedRoom<RigidBody> bodies[GroupSpace::kMostPieces];
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  TouchedPieces touched(state, pieces, tools, input);
  touched.list(room.sums);
  touched.join();
  BalancedGroup& group = room.group;
  touched.for_each(true, [&](Index first) {
    __syncthreads();
    if (thread == 0) {
      group.count = 0;
      for (Index piece = first; piece < pieces.count; ++piece) {
        if (pieces.touched[piece] == first) {
          bodies[group.count].get() = RigidBody(pieces.sums[piece]);
          group.pieces[group.count++] = piece;
        }
      }
    }
    __syncthreads();
    const Index listed =
        GroupList(state, pieces, tools, touched, group, input->substep.inverse_dt_squared).list();
    GroupBalance(BlockOfWorkers{thread, kMomentumSums}, &bodies[0].get(), group.count,
                 tools.group_contacts, listed, tools.group_answers, group.space)
        .run();
    for (Index rank = 0; rank < group.count; ++rank) {
      const Index piece = group.pieces[rank];
      const Screw twist = group.space.twist_of(rank);
      const RigidMove move{twist.linear, twist.angular, pieces.sums[piece].centre()};
      for_each_place(pieces, piece, [&](Index place) {
        const FlownVertex vertex(state, place);
        const Vec3<float> way = part_of(move, vertex.arm);
        if (vertex.counts() && is_finite_way(position_of(vertex.moved) + way)) {
          displace(state, place, way);
        }
      });
    }
    __syncthreads();
  });
}

void balance_pieces(const DeviceState& state, const FreePieceArrays& pieces,
                    const ToolArrays& tools, StepInput* input, const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the balance of pieces", 1, kMomentumSums, balance_touched, state, pieces,
           tools, input);
  }
}

void answer_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                             Index substep, const Launch& how) {
  if (tools.surfaces.has_springs) {
    launch(how, "launching springs of tools", 1, kSpringThreads, balance_springs, state, tools,
           input);
  }
  launch(how, "launching the answer of surfaces", share_blocks(kAnswerBlocks, 1, how), kToolThreads,
         answer_surfaces, state, tools, input, substep);
}

/// After all sweeps: which pieces keep their momentum together, as contacts push them. One block a
/// copy.
__global__ void __launch_bounds__(kMomentumSums)
    join_meeting(DeviceState state, FreePieceArrays pieces, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  pieces = of_copy(pieces);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index i = thread; i < pieces.count; i += kMomentumSums) {
    pieces.meeting[i] = group_of(pieces, i);
  }
  __syncthreads();
  if (thread >= kWarp) {
    return;
  }
  const Index count = contact_count(touches);
  for (Index first = 0; first < count; first += kWarp) {
    const Index c = first + thread;
    Index ids[2] = {kInvalidIndex, kInvalidIndex};  // pieces
    for (int side = 0; side < 2 && c < count; ++side) {
      if (touches.contacts[c].multiplier > 0) {
        ids[side] = __ldg(pieces.piece_of_place + touches.contacts[c].place_on(side));
      }
    }
    const bool is_any = ids[0] != kInvalidIndex || ids[1] != kInvalidIndex;
    for (unsigned left = __ballot_sync(~0U, is_any); left != 0; left &= left - 1) {
      const int from = __ffs(static_cast<int>(left)) - 1;
      const Index one = __shfl_sync(~0U, ids[0], from), other = __shfl_sync(~0U, ids[1], from);
      const Index a = one == kInvalidIndex ? one : pieces.meeting[one];
      const Index b = other == kInvalidIndex ? other : pieces.meeting[other];
      const Index low = a < b ? a : b, high = a < b ? b : a;  // kInvalidIndex is the least
      __syncwarp();
      for (Index i = thread; i < pieces.count && low != high; i += kWarp) {
        if (pieces.meeting[i] == high) {
          pieces.meeting[i] = low;
        }
      }
      __syncwarp();
    }
  }
}

void join_pieces(const DeviceState& state, const FreePieceArrays& pieces, const ToolArrays& tools,
                 const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching what joins pieces", 1, kMomentumSums, join_meeting, state, pieces,
           tools);
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
