// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What surfaces that tools touch answer: how stiffly they are met, what pushes back, and what is
/// left to the next substep; see surface_contacts.h.

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

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
  for (int k = 0; k < corners.count; ++k) {
    corners.places[k] = contact.feature.places[k];
  }
  load_corners(state, corners);
  const Vec3<float> shift = spring == nullptr ? Vec3<float>{} : spring->shift;
  const Vec3<float> displacement = spring == nullptr ? Vec3<float>{} : spring->displacement;
  turn_to(
      corners, swept[stored.swept].moved(displacement + shift), shift,
      [&](Index place) { return base_of(state, place); },
      [&](Index place) { return own_start(state, place); }, contact);
}

constexpr int kYieldThreads = 96;  // three for each contact

/// How stiffly contacts are met, once it is known what holds each vertex: a thread a corner.
template <bool kRowsChange>
__global__ void __launch_bounds__(kYieldThreads)
    find_yields(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                Index substep) {
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const SurfaceArrays& surfaces = tools.surfaces;
  const Index count = contact_count(surfaces);
  const SweptCapsule* const swept = swept_capsules(input, substep);
  __shared__ float yields[kYieldThreads];
  const auto is_likely = [&](const DeviceContact& stored) {
    return stored.contact.multiplier > 0 || read_contact(state, surfaces, stored).gap < 0;
  };
  for (Index first = static_cast<Index>(blockIdx.x) * kYieldThreads; first < 3 * count;
       first += thread_count()) {
    const Index hold = first + static_cast<Index>(threadIdx.x);
    const Index own = hold / 3, corner = hold % 3;
    float yield = 0;
    if (own < count && corner < surfaces.contacts[own].contact.feature.count()) {
      const SurfaceContact& contact = surfaces.contacts[own].contact;
      const Index place = contact.feature.places[corner];
      const float weight = contact.weights[corner];
      float pushes = is_likely(surfaces.contacts[own]) ? 0 : weight;
      for (Index h = surfaces.first_holds[place]; h != kInvalidIndex; h = surfaces.next_holds[h]) {
        const DeviceContact& other = surfaces.contacts[h / 3];
        pushes += is_likely(other) ? other.contact.weights[h % 3] : 0;
      }
      const VertexGive<float> give =
          find_loose_end<kRowsChange>(state, vertices, tools, input, substep, true, place).give;
      yield = weight * pushes * dot(contact.normal, give * contact.normal);
    }
    yields[threadIdx.x] = yield;
    __syncthreads();
    if (own < count && corner == 0) {
      const float sum = yields[threadIdx.x] + yields[threadIdx.x + 1] + yields[threadIdx.x + 2];
      SurfaceContact& contact = surfaces.contacts[own].contact;
      const float firmness = contact.capsule == kInvalidIndex
                                 ? kPlainFirmness
                                 : firmness_of(__ldg(surfaces.firmness + contact.feature.places[0]),
                                               swept[surfaces.contacts[own].swept].relative_way());
      contact.stiffness = sum > 0 ? firmness / sum : 0.0F;
    }
    __syncthreads();
  }
}

void begin_surface_contacts(const DeviceState& state, const VertexArrays& vertices,
                            const ToolArrays& tools, StepInput* input, Index substep,
                            const Launch& how) {
  launch(how, "launching how contacts are met", share_blocks(kAnswerBlocks, 1, how), kYieldThreads,
         vertices.is_damped ? find_yields<true> : find_yields<false>, state, vertices, tools, input,
         substep);
}

/// Moves corners by their masses, one level of contacts after another: the bits of one contact
/// after another. One block a copy.
/// @param settles  only those that are inside, without friction
__global__ void __launch_bounds__(kListThreads)
    project_surfaces(DeviceState state, ToolArrays tools, bool settles) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  Particle* const moving = moving_of(state);
  const auto project_level = [&](Index level) {
    bool is_any_inside = false;
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kListThreads) {
      DeviceContact& stored = surfaces.contacts[c];
      if (stored.level != level) {
        continue;
      }
      SurfaceContact contact = stored.contact;
      const int corners = contact.feature.count();
      ToolSpring* const spring = spring_of(surfaces, stored);
      float yield = spring == nullptr ? 0 : spring->yield;
      for (int k = 0; k < corners; ++k) {
        const float w = load_particle(moving + contact.feature.places[k]).w;
        yield += contact.weights[k] * contact.weights[k] * w;
      }
      const auto read = [&] {
        return read_contact(state, contact, spring == nullptr ? Vec3<float>{} : spring->shift);
      };
      if (settles && !(read().gap < 0)) {
        continue;
      }
      is_any_inside = true;
      project_contact(
          contact, settles ? 0.0F : stored.friction, yield, read, [&](const Vec3<float>& push) {
            if (spring != nullptr) {
              spring->shift = spring->shift - spring->yield * push;
            }
            for (int k = 0; k < corners; ++k) {
              Particle* const particle = moving + contact.feature.places[k];
              const Particle p = load_particle(particle);
              const Vec3<float> after = position_of(p) + (contact.weights[k] * p.w) * push;
              if (is_finite_way(after)) {
                store_particle(particle, after, p.w);
              }
            }
          });
      stored.contact = contact;
    }
    __syncthreads();
    return is_any_inside;
  };
  // one after another only where there is something to do
  const auto is_any_to_project = [&] {
    bool is_any = !settles;
    for (Index c = static_cast<Index>(threadIdx.x); c < count && !is_any; c += kListThreads) {
      is_any = read_contact(state, surfaces, surfaces.contacts[c]).gap < 0;
    }
    return __syncthreads_or(is_any) != 0;
  };
  bool is_any_inside = is_any_to_project();
  for (int pass = 0; pass < (settles ? kSettlePasses : 1) && is_any_inside; ++pass) {
    is_any_inside = false;
    for (Index level = 0; level < levels; ++level) {
      is_any_inside |= project_level(level);
    }
    is_any_inside = __syncthreads_or(is_any_inside) != 0;
  }
  for (Index c = static_cast<Index>(threadIdx.x); settles && c < count; c += kListThreads) {
    DeviceContact& stored = surfaces.contacts[c];
    stored.contact.is_left_inside = is_left_inside(read_contact(state, surfaces, stored));
  }
}

void project_surface_contacts(const DeviceState& state, const ToolArrays& tools, bool settles,
                              const Launch& how) {
  launch(how, "launching contacts with surfaces", 1, kListThreads, project_surfaces, state, tools,
         settles);
}

/// After a sweep of vertex blocks: see balance_spring(). One block a copy.
__global__ void __launch_bounds__(kListThreads)
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
    Answered of[kListThreads];
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
      for (Index first = begin; first < end; first += kListThreads) {
        const Index c = first + thread;
        __syncthreads();
        if (c < end) {
          const auto& [contact, friction, swept, spring, level] = surfaces.contacts[c];
          answers[thread] = {contact.normal, contact.stiffness,
                             answer(contact, friction, read_contact(state, contact, shift),
                                    inverse_dt_squared, contact.stiffness)};
        }
        __syncthreads();
        for (Index i = 0; i < kListThreads && first + i < end; ++i) {
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
    if (tells) {
      surfaces.told[c] = contact;
      surfaces.told_remembered[c] = now;
    }
  }
  for (Index m = thread_index(); m < input->meeter_count; m += thread_count()) {
    const MeeterInput& meeter =
        (table<MeeterInput>(input, input->meeters) + of_pusher(substep, input->meeter_count))[m];
    ToolSpring& spring = surfaces.springs[m];
    if (meeter.compliance > 0) {
      end_spring(meeter.stride, meeter.way, input->h, spring);
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

/// Of BDF2, as ease() for vertices that tools push: by levels. One block a copy.
__global__ void __launch_bounds__(kListThreads)
    ease_surfaces(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  for (Index level = 0; level < levels; ++level) {
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kListThreads) {
      const DeviceContact& stored = surfaces.contacts[c];
      const SurfaceContact& contact = stored.contact;
      if (stored.level != level || !(contact.multiplier > 0) || contact.is_eased) {
        continue;
      }
      for (int k = 0; k < contact.feature.count(); ++k) {
        const Index place = contact.feature.places[k];
        if (load_particle(state.particles + place).w > 0) {
          ease_vertex(state, place, contact.normal, input->inverse_h);
        }
      }
    }
    __syncthreads();
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
