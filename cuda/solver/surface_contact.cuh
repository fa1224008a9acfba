// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces as sweeps read them.

#include "cuda/solver/held_contact.cuh"
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
  surfaces.handed += of(surfaces.contact_room);
  surfaces.passed += surfaces.passed != nullptr ? of(place_room) : 0;
  surfaces.stopped += surfaces.stopped != nullptr ? of(place_room) : 0;
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

/// Of a hold, or kInvalidIndex.
__device__ inline Index place_of_corner(const SurfaceArrays& surfaces, Index hold) {
  return surfaces.contacts[hold / 3].contact.feature.places[hold % 3];
}

/// Where the holds of a place are.
__device__ inline HoldRange holds_of(const SurfaceArrays& surfaces, Index place) {
  if (surfaces.holds_at == nullptr) {
    return {};  // no tool has met surfaces yet
  }
  const int2 range = __ldcg(reinterpret_cast<const int2*>(surfaces.holds_at + place));
  return {range.x, range.y};
}

/// A contact as one of its corners has it.
template <>
struct HeldContact<SurfaceArrays> {
  DeviceContact stored;
  float weight;

  __device__ void load(const SurfaceArrays& surfaces, Index hold) {
    stored = surfaces.contacts[hold / 3];
    weight = hold % 3 == 0   ? stored.contact.weights[0]
             : hold % 3 == 1 ? stored.contact.weights[1]
                             : stored.contact.weights[2];
  }
  [[nodiscard]] __device__ ContactAnswer<float> answer_now(const DeviceState& state,
                                                           const SurfaceArrays& surfaces,
                                                           float inverse_dt_squared) const {
    return answer(stored.contact, stored.friction, read_contact(state, surfaces, stored),
                  inverse_dt_squared, stored.contact.stiffness);
  }
  [[nodiscard]] __device__ Vec3<float> normal() const { return stored.contact.normal; }
  [[nodiscard]] __device__ float stiffness() const { return stored.contact.stiffness; }
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
