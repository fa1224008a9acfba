// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How stiffly contacts are met, once it is known what holds each vertex.

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/shared_contacts.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// What all contacts of a kind have: arrays of a copy, normals, and how stiffly they are met by
/// what yields so much, m/N.
template <class Arrays>
struct YieldingContacts;

template <>
struct YieldingContacts<SurfaceArrays> {
  static constexpr int kCorners = 3;
  const SurfaceArrays& arrays;
  float inverse_square;  // of the substep's length, 1/s^2

  __device__ YieldingContacts(const ToolArrays& tools, float inverse_dt_squared)
      : arrays(tools.surfaces), inverse_square(inverse_dt_squared) {}
  [[nodiscard]] __device__ Vec3<float> normal(Index c) const {
    return arrays.contacts[c].contact.normal;
  }
  [[nodiscard]] __device__ float weight(Index c, Index corner) const {
    return arrays.contacts[c].contact.weights[corner];
  }
  __device__ void set(Index c, float yield) const {
    DeviceContact& stored = arrays.contacts[c];
    const ToolSpring* const spring = spring_of(arrays, stored);
    stored.contact.stiffness = met_stiffness(
        stored.firmness, yield, spring == nullptr ? 0.0F : stiffness_of(*spring, inverse_square));
  }
};

template <>
struct YieldingContacts<TouchArrays> {
  static constexpr int kCorners = TissueTouch::kCorners;
  const TouchArrays& arrays;

  __device__ YieldingContacts(const ToolArrays& tools, float /*inverse_dt_squared*/)
      : arrays(tools.touches) {}
  [[nodiscard]] __device__ Vec3<float> normal(Index c) const { return arrays.contacts[c].normal; }
  [[nodiscard]] __device__ float weight(Index c, Index corner) const {
    return fabsf(arrays.contacts[c].weights[corner]);
  }
  __device__ void set(Index c, float yield) const {
    arrays.contacts[c].stiffness = yield > 0 ? 1 / yield : 0.0F;
  }
};

constexpr int kYieldBlocks = 256;  // those without contacts end at once

/// Of two contacts at a time: kVertexParts threads a corner.
template <class Arrays>
constexpr int kYieldThreads = 2 * YieldingContacts<Arrays>::kCorners* kVertexParts;

template <class Arrays, bool kRowsChange>
__global__ void __launch_bounds__(kYieldThreads<Arrays>)
    find_yields(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                Index substep) {
  static_assert(kYieldThreads<Arrays> % kWarp == 0);
  constexpr Index kCorners = YieldingContacts<Arrays>::kCorners;
  constexpr Index kHolds = kYieldThreads<Arrays> / kVertexParts;  // of a block at a time
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const YieldingContacts<Arrays> contacts(tools, input->substep.inverse_dt_squared);
  const Index count = contact_count(contacts.arrays);
  __shared__ float yields[kHolds];
  const Index part = static_cast<Index>(threadIdx.x) % kVertexParts;
  const Index own_hold = static_cast<Index>(threadIdx.x) / kVertexParts;
  for (Index first = static_cast<Index>(blockIdx.x) * kHolds; first < kCorners * count;
       first += static_cast<Index>(gridDim.x) * kHolds) {
    const Index hold = first + own_hold;
    const Index own = hold / kCorners, corner = hold % kCorners;
    float yield = 0;
    const Index place = own < count ? place_of_corner(contacts.arrays, hold) : kInvalidIndex;
    if (place != kInvalidIndex) {
      const Vec3<float> normal = contacts.normal(own);
      const VertexGive<float> give =
          find_loose_end<kRowsChange>(state, vertices, tools, input, substep, true, place, part)
              .give;
      yield =
          contacts.weight(own, corner) * contacts.arrays.pushes[hold] * dot(normal, give * normal);
    }
    if (part == 0) {
      yields[own_hold] = yield;
    }
    __syncthreads();
    if (own < count && corner == 0 && part == 0) {
      float sum = 0;
      for (Index k = 0; k < kCorners; ++k) {
        sum += yields[own_hold + k];
      }
      contacts.set(own, sum);
    }
    __syncthreads();
  }
}

template <class Arrays>
void launch_yields(const Launch& how, const char* name, const DeviceState& state,
                   const VertexArrays& vertices, const ToolArrays& tools, StepInput* input,
                   Index substep) {
  launch(how, name, share_blocks(kYieldBlocks, 1, how), kYieldThreads<Arrays>,
         vertices.is_damped ? find_yields<Arrays, true> : find_yields<Arrays, false>, state,
         vertices, tools, input, substep);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
