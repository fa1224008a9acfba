// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that tools' surfaces or other bodies touch and nothing else holds, as kernels of one
/// block a copy find them: see touched_pieces.h.

#include <limits>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/momentum_kernels.cuh"
#include "cuda/solver/surface_contact.cuh"
#include "cuda/solver/touch_contact.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr Index kNoPiece = std::numeric_limits<Index>::max();

/// Shared memory for sums.
struct SumRoom {
  alignas(16) unsigned char bytes[kMomentumSums * sizeof(MomentumSums)];

  template <class Sums>
  __device__ Sums* of() {
    static_assert(sizeof(Sums) <= sizeof(MomentumSums));
    return reinterpret_cast<Sums*>(bytes);
  }
};

/// Where the weighted corners of a contact are, in what arm_at(place) says of them; of a contact
/// between bodies those of a side.
template <class ArmAt>
__device__ Vec3<double> arm_of_contact(const SurfaceContact& contact, const ArmAt& arm_at) {
  Vec3<double> sum{0, 0, 0};
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + static_cast<double>(contact.weights[k]) * arm_at(contact.feature.places[k]);
  }
  return sum;
}
template <class ArmAt>
__device__ Vec3<double> arm_of_contact(const TissueTouch& touch, int side, const ArmAt& arm_at) {
  const double sign = side == 0 ? 1 : -1;
  Vec3<double> sum{0, 0, 0};
  for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
    sum = sum + sign * static_cast<double>(touch.weights[k]) * arm_at(touch.places[k]);
  }
  return sum;
}

/// Pieces that contacts touch and nothing else holds, and with which of them each moves.
class TouchedPieces {
 public:
  __device__ TouchedPieces(const DeviceState& state, const FreePieceArrays& pieces,
                           const ToolArrays& tools, StepInput* input)
      : state_(state),
        pieces_(pieces),
        tools_(tools),
        input_(input),
        surface_count_(tools.surfaces.contact_room > 0 ? contact_count(tools.surfaces) : 0),
        touch_count_(tools.touches.contact_room > 0 ? contact_count(tools.touches) : 0) {}

  [[nodiscard]] __device__ Index surface_count() const { return surface_count_; }
  [[nodiscard]] __device__ Index touch_count() const { return touch_count_; }

  /// Lists them, each as a group of its own. All threads of the block call it.
  __device__ void list(SumRoom& room) {
    for (Index i = thread(); i < pieces_.count; i += kMomentumSums) {
      pieces_.touched[i] = kInvalidIndex;
    }
    for (Index piece = next_touched(kInvalidIndex); piece != kNoPiece;
         piece = next_touched(piece)) {
      if (is_held(piece)) {
        continue;
      }
      MomentumSums own;
      for_each_place(pieces_, piece, [&](Index place) {
        const FlownVertex vertex(state_, place);
        if (vertex.counts()) {
          own.add(1 / static_cast<double>(vertex.moved.w), vertex.arm,
                  to_double(position_of(vertex.moved) - vertex.flight));
        }
      });
      const MomentumSums sums = total(own, room.of<MomentumSums>());
      if (sums.mass > 0 && thread() == 0) {
        pieces_.touched[piece] = piece;
        pieces_.sums[piece] = sums;
      }
    }
    __syncthreads();
  }

  /// Makes groups of those that touch each other, in the order of contacts, as large as a group may
  /// be. All threads of the block call it.
  __device__ void join() {
    if (thread() < kWarp) {
      for (Index first = 0; first < touch_count_; first += kWarp) {
        const Index c = first + thread();
        Index ids[2] = {kInvalidIndex, kInvalidIndex};
        for (int side = 0; side < 2 && c < touch_count_; ++side) {
          ids[side] = find(tools_.touches.contacts[c].place_on(side));
        }
        const bool are_two = ids[0] != kInvalidIndex && ids[1] != kInvalidIndex && ids[0] != ids[1];
        for (unsigned left = __ballot_sync(~0U, are_two); left != 0; left &= left - 1) {
          const int from = __ffs(static_cast<int>(left)) - 1;
          join(__shfl_sync(~0U, ids[0], from), __shfl_sync(~0U, ids[1], from));
        }
      }
    }
    __syncthreads();
  }

  /// The one at a place, or kInvalidIndex.
  [[nodiscard]] __device__ Index find(Index place) const {
    const Index piece = piece_at(place);
    return piece == kInvalidIndex || pieces_.touched[piece] == kInvalidIndex ? kInvalidIndex
                                                                             : piece;
  }

  /// The first of its group.
  [[nodiscard]] __device__ Index group_of(Index piece) const { return pieces_.touched[piece]; }

  /// Calls visit(piece) for those that are the first of their group, or for all, ascending. All
  /// threads of the block call it, and may meet in it.
  template <class Visit>
  __device__ void for_each(bool groups, const Visit& visit) const {
    for (Index first = 0; first < pieces_.count; first += kMomentumSums) {
      const Index own = first + thread();
      const Index group = own < pieces_.count ? pieces_.touched[own] : kInvalidIndex;
      const bool is_wanted = group != kInvalidIndex && (!groups || group == own);
      __shared__ bool are_wanted[kMomentumSums];
      __syncthreads();
      are_wanted[thread()] = is_wanted;
      if (__syncthreads_or(is_wanted) == 0) {
        continue;
      }
      for (Index i = 0; i < kMomentumSums; ++i) {
        if (are_wanted[i]) {
          visit(first + i);
        }
      }
    }
  }

  /// Of a contact between bodies, the side that a piece has alone, or -1.
  [[nodiscard]] __device__ int side_of(const TissueTouch& touch, Index piece) const {
    const bool has_first = piece_at(touch.place_on(0)) == piece;
    const bool has_second = piece_at(touch.place_on(1)) == piece;
    return has_first == has_second ? -1 : (has_first ? 0 : 1);
  }

  /// The piece of a contact with a surface.
  [[nodiscard]] __device__ Index piece_of(Index contact) const {
    return piece_at(tools_.surfaces.contacts[contact].contact.feature.places[0]);
  }

 private:
  [[nodiscard]] __device__ static Index thread() { return static_cast<Index>(threadIdx.x); }

  /// The first of the pieces that move with the one at a place.
  [[nodiscard]] __device__ Index piece_at(Index place) const {
    return PBDSURG_KERNELS_NAMESPACE::group_of(pieces_, __ldg(pieces_.piece_of_place + place));
  }

  /// The first piece behind another that contacts touch, or kNoPiece.
  [[nodiscard]] __device__ Index next_touched(Index piece) const {
    __shared__ Index least;
    __syncthreads();
    if (thread() == 0) {
      least = kNoPiece;
    }
    __syncthreads();
    const auto consider = [&](Index own) {
      if (own > piece) {
        atomicMin(&least, own);
      }
    };
    for (Index c = thread(); c < surface_count_; c += kMomentumSums) {
      consider(piece_of(c));
    }
    for (Index c = thread(); c < touch_count_; c += kMomentumSums) {
      consider(piece_at(tools_.touches.contacts[c].place_on(0)));
      consider(piece_at(tools_.touches.contacts[c].place_on(1)));
    }
    __syncthreads();
    return least;
  }

  /// Whether tools hold a piece, or push it with vertices alone.
  [[nodiscard]] __device__ bool is_held(Index piece) const {
    bool is_any = false;
    const HeldInput* const held = table<HeldInput>(input_, input_->held);
    for (Index h = thread(); h < input_->held_count; h += kMomentumSums) {
      is_any |= piece_at(held[h].place) == piece;
    }
    for (Index pusher = 0; pusher < input_->pusher_count; ++pusher) {
      const Index* const places = tools_.contact_places + row_at(pusher, tools_.contact_room);
      for (Index i = thread(); i < tools_.contact_counts[pusher]; i += kMomentumSums) {
        is_any |= piece_at(places[i]) == piece;
      }
    }
    return __syncthreads_or(is_any) != 0;
  }

  /// By a warp.
  __device__ void join(Index first, Index second) {
    const Index one = pieces_.touched[first], other = pieces_.touched[second];
    const Index a = one < other ? one : other, b = one < other ? other : one;
    Index size = 0;
    for (Index i = thread(); i < pieces_.count; i += kWarp) {
      size += pieces_.touched[i] == a || pieces_.touched[i] == b ? 1 : 0;
    }
    for (int distance = kWarp / 2; distance > 0; distance /= 2) {
      size += __shfl_xor_sync(~0U, size, distance);
    }
    if (a != b && size <= GroupSpace::kMostPieces) {
      for (Index i = thread(); i < pieces_.count; i += kWarp) {
        if (pieces_.touched[i] == b) {
          pieces_.touched[i] = a;
        }
      }
    }
    __syncwarp();
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  const ToolArrays& tools_;
  StepInput* input_;
  Index surface_count_, touch_count_;
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
