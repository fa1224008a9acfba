// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Touched pieces leave what they touch no faster than on the way of a substep: see piece_easing.h.

#include "cuda/solver/surface_projection_kernels.cuh"
#include "cuda/solver/touched_pieces.cuh"
#include "lib/solver/methods/piece_easing.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// A piece as it is eased.
class EasedPiece {
 public:
  __device__ EasedPiece(const DeviceState& state, const FreePieceArrays& pieces, Index piece,
                        SumRoom& room)
      : state_(state), pieces_(pieces), piece_(piece), room_(room) {
    MomentumSums own;
    for_each_counted([&](Index place, const FlownVertex& vertex) {
      own.add(1 / static_cast<double>(vertex.moved.w), position(place), {0, 0, 0});
    });
    pushes_.sums = total(own, room_.of<MomentumSums>());
  }

  [[nodiscard]] __device__ Index piece() const { return piece_; }
  [[nodiscard]] __device__ const Pushes& pushes() const { return pushes_; }

  /// Contacts in their order; each thread adds up all.
  __device__ void add(const SurfaceContact& contact) {
    pushes_.add(contact.multiplier, contact.normal,
                arm_of_contact(contact, [&](Index place) { return position(place); }));
  }
  __device__ void add(const TissueTouch& touch, int side) {
    pushes_.add(touch.multiplier, side == 0 ? touch.normal : -1.0F * touch.normal,
                arm_of_contact(touch, 1, [&](Index place) { return position(place); }));
  }

  /// Once all pushes are added.
  [[nodiscard]] __device__ EasingSums sums(float h) {
    motion_ = pushes_.sums.rigid_move();
    EasingSums along;
    for_each_counted([&](Index place, const FlownVertex& vertex) {
      along.add(1 / static_cast<double>(vertex.moved.w),
                to_double(part_of(motion_, position(place))),
                load_velocity(state_.velocities + place), load_way(state_.ways + place),
                load_velocity(state_.velocities_before + place), h);
    });
    return total(along, room_.of<EasingSums>());
  }

  __device__ void ease(const Easing& easing) const {
    for_each_counted([&](Index place, const FlownVertex&) {
      const Vec3<float> way = part_of(motion_, position(place));
      Velocity* const now = state_.velocities + place;
      Velocity* const before = state_.velocities_before + place;
      store_velocity(now, load_velocity(now) + static_cast<float>(easing.now) * way);
      store_velocity(before, load_velocity(before) + static_cast<float>(easing.before) * way);
    });
    __syncthreads();
  }

 private:
  [[nodiscard]] __device__ Vec3<double> position(Index place) const {
    return to_double(position_of(load_particle(state_.particles + place)));
  }
  template <class Visit>
  __device__ void for_each_counted(const Visit& visit) const {
    for_each_place(pieces_, piece_, [&](Index place) {
      const FlownVertex vertex(state_, place);
      if (vertex.counts()) {
        visit(place, vertex);
      }
    });
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  Index piece_;
  SumRoom& room_;
  Pushes pushes_{};
  RigidMove motion_{};
};

/// Off tools and what has no such motion.
__device__ inline void ease_alone(const ToolArrays& tools, const TouchedPieces& touched,
                                  const StepInput* input, EasedPiece& eased) {
  const auto for_each = [&](Index from, Index stride, const auto& visit_touch,
                            const auto& visit_surface) {
    for (Index c = from; c < touched.touch_count(); c += stride) {
      TissueTouch& touch = tools.touches.contacts[c];
      const int side = touched.side_of(touch, eased.piece());
      if (side >= 0 && touched.find(touch.place_on(1 - side)) == kInvalidIndex) {
        visit_touch(touch, side);
      }
    }
    for (Index c = from; c < touched.surface_count(); c += stride) {
      if (touched.piece_of(c) == eased.piece()) {
        visit_surface(tools.surfaces.contacts[c].contact);
      }
    }
  };
  for_each(
      0, 1, [&](const TissueTouch& touch, int side) { eased.add(touch, side); },
      [&](const SurfaceContact& contact) { eased.add(contact); });
  const Easing easing = eased.sums(input->h).easing(eased.pushes());
  eased.ease(easing);
  const float relief = relief_of(easing, input->h, input->per_step, input->density);
  for_each(
      static_cast<Index>(threadIdx.x), kMomentumSums,
      [](TissueTouch& touch, int) { touch.is_eased = true; },
      [&](SurfaceContact& contact) {
        contact.is_eased = true;
        contact.relief = relief;
      });
  __syncthreads();
}

/// Off each other. What both have in common of mass stands for that of one.
__device__ inline void ease_pair(const DeviceState& state, const FreePieceArrays& pieces,
                                 const ToolArrays& tools, const TouchedPieces& touched,
                                 const StepInput* input, Index first, Index second, SumRoom& room) {
  EasedPiece one(state, pieces, first, room);
  EasedPiece other(state, pieces, second, room);
  for (Index c = 0; c < touched.touch_count(); ++c) {
    const TissueTouch& touch = tools.touches.contacts[c];
    const int side = touched.side_of(touch, first);
    if (side >= 0 && touched.find(touch.place_on(1 - side)) == second) {
      one.add(touch, side);
      other.add(touch, 1 - side);
    }
  }
  __syncthreads();
  for (Index c = static_cast<Index>(threadIdx.x); c < touched.touch_count(); c += kMomentumSums) {
    TissueTouch& touch = tools.touches.contacts[c];
    const int side = touched.side_of(touch, first);
    if (side >= 0 && touched.find(touch.place_on(1 - side)) == second) {
      touch.is_eased = true;
    }
  }
  EasingSums sums = one.sums(input->h);
  sums.add(other.sums(input->h));
  const Easing easing = sums.easing(between(one.pushes(), other.pushes()));
  one.ease(easing);
  other.ease(easing);
}

/// The pair of pieces behind another that push each other, or kNoPair.
constexpr unsigned long long kNoPair = ~0ULL;
__device__ inline unsigned long long next_pair(const ToolArrays& tools,
                                               const TouchedPieces& touched,
                                               unsigned long long behind, bool is_first) {
  __shared__ unsigned long long least;
  __syncthreads();
  if (threadIdx.x == 0) {
    least = kNoPair;
  }
  __syncthreads();
  for (Index c = static_cast<Index>(threadIdx.x); c < touched.touch_count(); c += kMomentumSums) {
    const TissueTouch& touch = tools.touches.contacts[c];
    const Index a = touched.find(touch.place_on(0)), b = touched.find(touch.place_on(1));
    if (touch.multiplier > 0 && a != kInvalidIndex && b != kInvalidIndex && a != b) {
      const auto low = static_cast<unsigned>(a < b ? a : b);
      const auto high = static_cast<unsigned>(a < b ? b : a);
      const unsigned long long own = static_cast<unsigned long long>(low) << 32 | high;
      if (is_first || own > behind) {
        atomicMin(&least, own);
      }
    }
  }
  __syncthreads();
  return least;
}

__global__ void __launch_bounds__(kMomentumSums)
    ease_touched(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input,
                 Index substep) {
  wait_for_previous();
  __shared__ SumRoom room;
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  TouchedPieces touched(state, pieces, tools, input);
  touched.list(room);
  touched.for_each(false, [&](Index piece) {
    EasedPiece eased(state, pieces, piece, room);
    ease_alone(tools, touched, input, eased);
  });
  for (unsigned long long pair = next_pair(tools, touched, 0, true); pair != kNoPair;
       pair = next_pair(tools, touched, pair, false)) {
    ease_pair(state, pieces, tools, touched, input, static_cast<Index>(pair >> 32),
              static_cast<Index>(pair & ~0U), room);
  }
  const SurfaceArrays& surfaces = tools.surfaces;
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

void ease_pieces(const DeviceState& state, const FreePieceArrays& pieces, const ToolArrays& tools,
                 StepInput* input, Index substep, const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the easing of pieces", 1, kMomentumSums, ease_touched, state, pieces,
           tools, input, substep);
  }
}

void ease_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                           const Launch& how) {
  launch(how, "launching the easing of surfaces", 1, kProjectThreads, ease_surfaces, state, tools,
         input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
