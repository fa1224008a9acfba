// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts between bodies as sweeps read them: see touch_response.h.

#include "cuda/solver/held_contact.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

__device__ inline TouchArrays of_copy(TouchArrays touches, Index place_room) {
  const auto of = [](Index room) { return copy_index() * static_cast<std::size_t>(room); };
  constexpr Index kCorners = TissueTouch::kCorners;
  touches.boxes += of(touches.triangle_group_count + touches.edge_group_count);
  touches.searches += copy_index();
  touches.seen += of(touches.vertex_count);
  touches.near += of(touches.vertex_count + touches.edge_count);
  touches.is_met += of(touches.vertex_count);
  touches.crossings += of(touches.crossing_room);
  touches.found += of(touches.vertex_count + touches.crossing_room);
  touches.last_holds += of(place_room);
  touches.order += of(touches.contact_room);
  touches.contacts += of(touches.contact_room);
  touches.counts += copy_index();
  touches.level_counts += copy_index();
  touches.holds_at += touches.holds_at != nullptr ? of(place_room) : 0;
  touches.holds += of(kCorners * touches.contact_room);
  touches.roots += of(kCorners * touches.contact_room);
  touches.befores += of(kCorners * touches.contact_room);
  touches.pushes += of(kCorners * touches.contact_room);
  touches.levels += of(touches.crossing_room);
  touches.remembered += of(touches.contact_room);
  touches.remembered_counts += copy_index();
  touches.told += of(touches.contact_room);
  touches.told_remembered += of(touches.contact_room);
  touches.told_counts += copy_index();
  return touches;
}

__device__ inline Index contact_count(const TouchArrays& touches) {
  return __ldcg(touches.counts);
}

/// Of a hold; kInvalidIndex where its contact does not depend on it.
__device__ inline Index place_of_corner(const TouchArrays& touches, Index hold) {
  constexpr Index kCorners = TissueTouch::kCorners;
  const TissueTouch& touch = touches.contacts[hold / kCorners];
  return touch.weights[hold % kCorners] != 0 ? touch.places[hold % kCorners] : kInvalidIndex;
}

/// Where the holds of a place are.
__device__ inline HoldRange holds_of(const TouchArrays& touches, Index place) {
  if (touches.holds_at == nullptr) {
    return {};  // no bodies meet
  }
  const int2 range = __ldcg(reinterpret_cast<const int2*>(touches.holds_at + place));
  return {range.x, range.y};
}

/// m, sum(weights * u) of a side.
__device__ inline Vec3<float> sum_of_side(const DeviceState& state, const TissueTouch& touch,
                                          int side) {
  Vec3<float> sum;
#pragma unroll
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    if (touch.side_of(k) == side) {
      sum = sum + touch.weights[k] * position_of(load_particle(moving_of(state) + touch.places[k]));
    }
  }
  return sum;
}

/// A contact as one of its corners has it.
template <>
struct HeldContact<TouchArrays> {
  TissueTouch touch;
  int side;
  float weight;

  __device__ void load(const TouchArrays& touches, Index hold) {
    touch = touches.contacts[hold / TissueTouch::kCorners];
    const int corner = hold % TissueTouch::kCorners;
    side = touch.side_of(corner);
    weight = corner == 0   ? touch.weights[0]
             : corner == 1 ? touch.weights[1]
             : corner == 2 ? touch.weights[2]
                           : touch.weights[3];
  }
  /// It sees the other side where that was when the sweep began.
  [[nodiscard]] __device__ ContactAnswer<float> answer_now(const DeviceState& state,
                                                           const TouchArrays& /*touches*/,
                                                           float inverse_dt_squared) const {
    const Vec3<float> sum =
        sum_of_side(state, touch, side) + (side == 0 ? touch.seen[1] : touch.seen[0]);
    return answer(touch, touch.mu, read_plane(touch, sum), inverse_dt_squared, touch.stiffness);
  }
  [[nodiscard]] __device__ Vec3<float> normal() const { return touch.normal; }
  [[nodiscard]] __device__ float stiffness() const { return touch.stiffness; }
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
