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
  surfaces.keys += of(surfaces.contact_room);
  surfaces.sorted_keys += of(surfaces.contact_room);
  surfaces.order += of(surfaces.contact_room);
  surfaces.contacts += of(surfaces.contact_room);
  surfaces.ends += of(1 + surfaces.meeter_room);
  surfaces.level_counts += copy_index();
  surfaces.first_holds += surfaces.first_holds != nullptr ? of(place_room) : 0;
  surfaces.next_holds += of(3 * surfaces.contact_room);
  surfaces.roots += of(3 * surfaces.contact_room);
  surfaces.likely_weights += of(3 * surfaces.contact_room);
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

/// Adds the surface contacts of a vertex to its energy; the last first, as on the host.
__device__ inline void add_surface_contacts(const DeviceState& state, const SurfaceArrays& surfaces,
                                            Index place, float inverse_dt_squared,
                                            VertexEnergy<float>& energy) {
  if (surfaces.first_holds == nullptr) {
    return;  // no tool has met surfaces yet
  }
  for (Index hold = __ldcg(surfaces.first_holds + place); hold != kInvalidIndex;
       hold = __ldcg(surfaces.next_holds + hold)) {
    const DeviceContact& stored = surfaces.contacts[hold / 3];
    const SurfaceContact& contact = stored.contact;
    add_answer(contact,
               answer(contact, stored.friction, read_contact(state, surfaces, stored),
                      inverse_dt_squared, contact.stiffness),
               contact.weights[hold % 3], energy);
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
