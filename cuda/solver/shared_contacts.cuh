// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts at a vertex, with surfaces or between bodies.

#include "cuda/solver/surface_contact.cuh"
#include "cuda/solver/touch_contact.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// Calls visit(place, root) for each corner that contacts have, once.
/// @param threads  of the block, that share them
template <class Arrays, class Visit>
__device__ inline void for_each_corner(const Arrays& arrays, Index holds, Index threads,
                                       const Visit& visit) {
  for (Index hold = static_cast<Index>(threadIdx.x); hold < holds; hold += threads) {
    const Index place = place_of_corner(arrays, hold);
    if (place != kInvalidIndex && arrays.roots[hold] == hold) {
      visit(place, hold);
    }
  }
}

/// What add_answer() reads of a contact.
struct AnsweringContact {
  Vec3<float> normal;
  float stiffness;
};

/// Adds the contacts of a vertex to its energy; the last first, as on the host.
template <class Arrays>
__device__ inline void add_contacts(const DeviceState& state, const Arrays& arrays, Index place,
                                    float inverse_dt_squared, VertexEnergy<float>& energy) {
  const HoldRange range = holds_of(arrays, place);
  for (Index i = 0; i < range.count; ++i) {
    HeldContact<Arrays> held;
    held.load(arrays, __ldcg(arrays.holds + range.first + i));
    add_answer(AnsweringContact{held.normal(), held.stiffness()},
               held.answer_now(state, arrays, inverse_dt_squared), held.weight, energy);
  }
}

/// The same by neighbouring threads of a warp that share a vertex, a contact each at a time. What
/// does not change in a sweep they load before they wait for other vertices.
/// @tparam kThreads  of a vertex
template <int kThreads, class Arrays>
class SharedContacts {
 public:
  /// @param part  of the vertex
  __device__ SharedContacts(const Arrays& arrays, Index part) : arrays_(arrays), part_(part) {}

  /// @param range  of the vertex
  __device__ void load(const HoldRange& range) {
    range_ = range;
    load_from(0);
  }

  /// All threads of the warp call it, where vertices are.
  /// @param energy  of the vertex; the first of its threads comes to know it
  __device__ void add(const DeviceState& state, float inverse_dt_squared,
                      VertexEnergy<float>& energy) {
    for (Index first = 0; __any_sync(~0U, first < range_.count) != 0; first += kThreads) {
      if (first > 0) {
        load_from(first);
      }
      ContactAnswer<float> own{};
      if (first + part_ < range_.count) {
        own = held_.answer_now(state, arrays_, inverse_dt_squared);
      }
      const unsigned of_warp = __ballot_sync(~0U, own.force.push > 0);
      const Index leader = static_cast<Index>(threadIdx.x) % kWarp - part_;
      unsigned left = of_warp >> leader & ((1ULL << kThreads) - 1);
      while (__any_sync(~0U, left != 0) != 0) {
        const int from = leader + (left != 0 ? __ffs(static_cast<int>(left)) - 1 : 0);
        const AnsweringContact contact{shuffle(held_.normal(), from),
                                       __shfl_sync(~0U, held_.stiffness(), from)};
        const float weight = __shfl_sync(~0U, held_.weight, from);
        const ContactAnswer<float> met{
            {__shfl_sync(~0U, own.force.push, from), shuffle(own.force.drag, from)},
            __shfl_sync(~0U, own.sticking, from)};
        if (left != 0) {
          add_answer(contact, met, weight, energy);
        }
        left &= left - 1;
      }
    }
  }

 private:
  __device__ void load_from(Index first) {
    if (first + part_ < range_.count) {
      held_.load(arrays_, __ldcg(arrays_.holds + range_.first + first + part_));
    }
  }
  [[nodiscard]] __device__ static Vec3<float> shuffle(const Vec3<float>& v, int from) {
    return {__shfl_sync(~0U, v.x, from), __shfl_sync(~0U, v.y, from), __shfl_sync(~0U, v.z, from)};
  }

  const Arrays& arrays_;
  Index part_;
  HoldRange range_{};
  HeldContact<Arrays> held_;
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
