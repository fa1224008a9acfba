// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What surfaces that tools touch answer: how stiffly they are met, what pushes back, and what is
/// left to the next substep; see surface_contacts.h.

#include "cuda/solver/contact_yields.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kSpringThreads = 256;
constexpr int kAnswerBlocks = 8;  // whatever the number of contacts, which the host does not know

/// See follow_feature().
/// @param swept    capsules of the substep
/// @param spring   of the tool; null if it has none
__device__ inline void follow_feature(const DeviceState& state, const SweptCapsule* swept,
                                      const ToolSpring* spring, const DeviceContact& stored,
                                      SurfaceContact& contact) {
  if (stored.swept == kInvalidIndex) {
    return;
  }
  FeatureCorners corners;
  corners.count = contact.feature.count();
  corners.for_each([&](int k) { corners.places[k] = contact.feature.places[k]; });
  load_corners(state, corners);
  if (spring != nullptr) {
    corners.take_as_free();
  }
  const Vec3<float> shift = spring == nullptr ? Vec3<float>{} : spring->shift;
  const Vec3<float> displacement = spring == nullptr ? Vec3<float>{} : spring->displacement;
  turn_to(
      corners, swept[stored.swept].moved(displacement + shift), shift,
      [&](Index place) { return base_of(state, place); },
      [&](Index place) { return own_start(state, place); }, contact);
}

void begin_surface_contacts(const DeviceState& state, const VertexArrays& vertices,
                            const ToolArrays& tools, StepInput* input, Index substep,
                            const Launch& how) {
  launch_yields<SurfaceArrays>(how, "launching how contacts are met", state, vertices, tools, input,
                               substep);
}

/// After a sweep of vertex blocks: see balance_spring(). One block a copy.
__global__ void __launch_bounds__(kSpringThreads)
    balance_springs(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const auto thread = static_cast<Index>(threadIdx.x);
  struct Answered {
    Vec3<float> normal;
    float stiffness;
    ContactAnswer<float> answer;
  };
  struct AllAnswered {
    Answered of[kSpringThreads];
  };
  __shared__ SharedRoom<AllAnswered> room;
  Answered* const answers = room.get().of;
  for (Index m = 0; m < input->meeter_count; ++m) {
    const Index begin = surfaces.ends[m], end = surfaces.ends[m + 1];
    ToolSpring spring = surfaces.springs[m];
    if (!(spring.yield > 0)) {
      continue;  // it has none
    }
    // all threads add up all of them, in their order, and come to the same bits
    const auto add_answers = [&](const Vec3<float>& shift, VertexEnergy<float>& energy) {
      for (Index first = begin; first < end; first += kSpringThreads) {
        const Index c = first + thread;
        __syncthreads();
        if (c < end) {
          const DeviceContact& stored = surfaces.contacts[c];
          const SurfaceContact& contact = stored.contact;
          answers[thread] = {contact.normal, contact.stiffness,
                             answer(contact, stored.friction, read_contact(state, contact, shift),
                                    inverse_dt_squared, contact.stiffness)};
        }
        __syncthreads();
        for (Index i = 0; i < kSpringThreads && first + i < end; ++i) {
          add_answer(answers[i], answers[i].answer, -1, energy);
        }
      }
    };
    balance_spring(inverse_dt_squared, add_answers, spring);
    __syncthreads();
    if (thread == 0) {
      surfaces.springs[m] = spring;
    }
  }
}

/// After a sweep of vertex blocks, multipliers become the forces of the contacts, and their planes
/// follow what they meet.
__global__ void __launch_bounds__(kToolThreads)
    answer_surfaces(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const float square = 1 / inverse_dt_squared;
  const SweptCapsule* const swept = swept_capsules(input, substep);
  const Index count = contact_count(surfaces);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    DeviceContact& stored = surfaces.contacts[c];
    SurfaceContact contact = stored.contact;
    take_over(contact,
              answer(contact, stored.friction, read_contact(state, surfaces, stored),
                     inverse_dt_squared, contact.stiffness)
                  .force,
              square);
    follow_feature(state, swept, spring_of(surfaces, stored), stored, contact);
    stored.contact = contact;
  }
}

/// What the next substep has to know, and after the last one the host.
__global__ void __launch_bounds__(kToolThreads)
    remember(ToolArrays tools, StepInput* input, Index place_room, Index substep, bool tells) {
  wait_for_previous();
  const SurfaceArrays surfaces = of_copy(tools, place_room).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Index count = contact_count(surfaces);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    const SurfaceContact& contact = surfaces.contacts[c].contact;
    const RememberedContact now = remembered(contact, inverse_dt_squared);
    surfaces.remembered[c] = now;
    for (int k = 0; k < contact.feature.count(); ++k) {
      surfaces.holds_at[contact.feature.places[k]] = {};
    }
    if (tells) {
      surfaces.told[c] = contact;
      surfaces.told_remembered[c] = now;
    }
  }
  for (Index m = thread_index(); m < input->meeter_count; m += thread_count()) {
    const MeeterInput& meeter =
        (table<MeeterInput>(input, input->meeters) + row_at(substep, input->meeter_count))[m];
    ToolSpring& spring = surfaces.springs[m];
    if (meeter.compliance > 0) {
      end_spring(meeter.stride, meeter.told, meeter.way, input->h, spring);
    }
    if (tells) {
      surfaces.told_springs[m] = spring;
    }
  }
  for (Index m = thread_index(); m <= surfaces.meeter_room; m += thread_count()) {
    const Index end = __ldcg(surfaces.ends + m);
    surfaces.remembered_ends[m] = end;
    if (tells) {
      surfaces.told_ends[m] = end;
    }
  }
}

void remember_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                               Index substep, bool tells, const Launch& how) {
  launch(how, "launching what is remembered of contacts", share_blocks(kAnswerBlocks, 1, how),
         kToolThreads, remember, tools, input, state.capacity, substep, tells);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
