// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces as sweeps read them.

#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

__device__ inline SurfaceArrays of_copy(SurfaceArrays surfaces, Index place_room) {
  const auto of = [](Index room) { return copy_index() * static_cast<std::size_t>(room); };
  surfaces.met_counts += of(surfaces.meeter_room);
  surfaces.found += of(surfaces.contact_room);
  surfaces.list_memory += of(surfaces.contact_room) * kListBytes;
  surfaces.contacts += of(surfaces.contact_room);
  surfaces.ends += of(1 + surfaces.meeter_room);
  surfaces.level_counts += copy_index();
  surfaces.holds_at += surfaces.holds_at != nullptr ? of(place_room) : 0;
  surfaces.holds += of(3 * surfaces.contact_room);
  surfaces.roots += of(3 * surfaces.contact_room);
  surfaces.pushes += of(3 * surfaces.contact_room);
  surfaces.levels += of(surfaces.contact_room);
  surfaces.rigid += of(surfaces.contact_room);
  surfaces.springs += of(surfaces.meeter_room);
  surfaces.remembered += of(surfaces.contact_room);
  surfaces.remembered_ends += of(1 + surfaces.meeter_room);
  surfaces.told += of(surfaces.contact_room);
  surfaces.told_remembered += of(surfaces.contact_room);
  surfaces.told_ends += of(1 + surfaces.meeter_room);
  surfaces.told_springs += of(surfaces.meeter_room);
  return surfaces;
}

/// Where a contact is now.
/// @param shift  m, of its tool
__device__ inline ContactReading<float> read_contact(const DeviceState& state,
                                                     const SurfaceContact& contact,
                                                     const Vec3<float>& shift) {
  Vec3<float> sum;
#pragma unroll
  for (int k = 0; k < 3; ++k) {
    const Index place = contact.feature.places[k];
    if (place != kInvalidIndex) {
      sum = sum + contact.weights[k] * position_of(load_particle(moving_of(state) + place));
    }
  }
  return read_plane(contact, sum - shift);
}

/// Of the tool of a contact; null if it has none.
__device__ inline ToolSpring* spring_of(const SurfaceArrays& surfaces,
                                        const DeviceContact& stored) {
  return stored.spring == kInvalidIndex ? nullptr : surfaces.springs + stored.spring;
}

__device__ inline ContactReading<float> read_contact(const DeviceState& state,
                                                     const SurfaceArrays& surfaces,
                                                     const DeviceContact& stored) {
  const ToolSpring* const spring = spring_of(surfaces, stored);
  return read_contact(state, stored.contact, spring == nullptr ? Vec3<float>{} : spring->shift);
}

__device__ inline Index contact_count(const SurfaceArrays& surfaces) {
  return __ldcg(surfaces.ends + surfaces.meeter_room);
}

/// Calls visit(place, root) for each corner that contacts have, once.
/// @param threads  of the block, that share them
template <class Visit>
__device__ inline void for_each_corner(const SurfaceArrays& surfaces, Index count, Index threads,
                                       const Visit& visit) {
  for (Index hold = static_cast<Index>(threadIdx.x); hold < 3 * count; hold += threads) {
    const Index place = surfaces.contacts[hold / 3].contact.feature.places[hold % 3];
    if (place != kInvalidIndex && surfaces.roots[hold] == hold) {
      visit(place, hold);
    }
  }
}

/// Where the holds of a place are.
__device__ inline HoldRange holds_of(const SurfaceArrays& surfaces, Index place) {
  if (surfaces.holds_at == nullptr) {
    return {};  // no tool has met surfaces yet
  }
  const int2 range = __ldcg(reinterpret_cast<const int2*>(surfaces.holds_at + place));
  return {range.x, range.y};
}

/// Adds the surface contacts of a vertex to its energy; the last first, as on the host.
__device__ inline void add_surface_contacts(const DeviceState& state, const SurfaceArrays& surfaces,
                                            Index place, float inverse_dt_squared,
                                            VertexEnergy<float>& energy) {
  const HoldRange range = holds_of(surfaces, place);
  for (Index i = 0; i < range.count; ++i) {
    const Index hold = __ldcg(surfaces.holds + range.first + i);
    const DeviceContact& stored = surfaces.contacts[hold / 3];
    const SurfaceContact& contact = stored.contact;
    add_answer(contact,
               answer(contact, stored.friction, read_contact(state, surfaces, stored),
                      inverse_dt_squared, contact.stiffness),
               contact.weights[hold % 3], energy);
  }
}

/// The same by neighbouring threads of a warp that share a vertex, a contact each at a time. What
/// does not change in a sweep they load before they wait for other vertices.
/// @tparam kThreads  of a vertex
template <int kThreads>
class SharedContacts {
 public:
  /// @param part  of the vertex
  __device__ SharedContacts(const SurfaceArrays& surfaces, Index part)
      : surfaces_(surfaces), part_(part) {}

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
        own = answer(stored_.contact, stored_.friction, read_contact(state, surfaces_, stored_),
                     inverse_dt_squared, stored_.contact.stiffness);
      }
      const unsigned of_warp = __ballot_sync(~0U, own.force.push > 0);
      const Index leader = static_cast<Index>(threadIdx.x) % kWarp - part_;
      unsigned left = of_warp >> leader & ((1ULL << kThreads) - 1);
      while (__any_sync(~0U, left != 0) != 0) {
        const int from = leader + (left != 0 ? __ffs(static_cast<int>(left)) - 1 : 0);
        SurfaceContact contact;
        contact.normal = shuffle(stored_.contact.normal, from);
        contact.stiffness = __shfl_sync(~0U, stored_.contact.stiffness, from);
        const float weight = __shfl_sync(~0U, weight_, from);
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
      const Index hold = __ldcg(surfaces_.holds + range_.first + first + part_);
      stored_ = surfaces_.contacts[hold / 3];
      weight_ = hold % 3 == 0   ? stored_.contact.weights[0]
                : hold % 3 == 1 ? stored_.contact.weights[1]
                                : stored_.contact.weights[2];
    }
  }
  [[nodiscard]] __device__ static Vec3<float> shuffle(const Vec3<float>& v, int from) {
    return {__shfl_sync(~0U, v.x, from), __shfl_sync(~0U, v.y, from), __shfl_sync(~0U, v.z, from)};
  }

  const SurfaceArrays& surfaces_;
  Index part_;
  HoldRange range_{};
  DeviceContact stored_;
  float weight_ = 0;
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
