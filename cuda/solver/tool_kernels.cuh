// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools: contacts, grasps and forces.

#include <cub/block/block_scan.cuh>

#include "pbdsurg/constraints/attachment.h"
#include "pbdsurg/constraints/contact.h"

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/shared_contacts.cuh"
#include "cuda/solver/vertex_kernels.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kToolThreads = 256;
constexpr int kHeldBlocks = 16;  // whatever the number of vertices held, which may change
constexpr int kForceBlocks = 8;  // tools at a time, likewise; of all copies together, if they can

__device__ inline ToolArrays of_copy(ToolArrays tools, Index place_room) {
  const std::size_t pushers = copy_index() * static_cast<std::size_t>(tools.pusher_room);
  tools.touched += pushers * static_cast<std::size_t>(tools.word_count);
  tools.planes += pushers * static_cast<std::size_t>(place_room);
  tools.contact_multipliers += pushers * static_cast<std::size_t>(place_room);
  tools.contact_points += pushers * static_cast<std::size_t>(place_room);
  tools.contact_places += pushers * static_cast<std::size_t>(tools.contact_room);
  tools.contact_counts += pushers;
  tools.attachment_multipliers += copy_index() * static_cast<std::size_t>(tools.attachment_room);
  tools.told_grips += copy_index() * static_cast<std::size_t>(tools.grip_room);
  tools.told_points += copy_index() * static_cast<std::size_t>(tools.point_room);
  tools.surfaces = of_copy(tools.surfaces, place_room);
  tools.touches = of_copy(tools.touches, place_room);
  tools.group_contacts += copy_index() * static_cast<std::size_t>(tools.group_room);
  tools.group_answers += copy_index() * static_cast<std::size_t>(tools.group_room);
  return tools;
}

/// Of the contacts found, keeps the first up to the capacity, and lists them. One block.
__device__ void keep_contacts(const ToolArrays& tools, StepInput* input) {
  using Scan = cub::BlockScan<Index, kToolThreads>;
  __shared__ typename Scan::TempStorage storage;
  const Index capacity = input->contact_capacity;
  Index all = 0;
  Index dropped = 0;
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    std::uint32_t* const touched = tools.touched + row_at(pusher, tools.word_count);
    Index* const places = tools.contact_places + row_at(pusher, tools.contact_room);
    Index found = 0;
    for (Index first = 0; first < tools.word_count; first += kToolThreads) {
      const Index word = first + static_cast<Index>(threadIdx.x);
      std::uint32_t bits = word < tools.word_count ? __ldcg(touched + word) : 0;
      Index rank = 0;
      Index sum = 0;
      Scan(storage).ExclusiveSum(__popc(bits), rank, sum);
      __syncthreads();  // the storage is used again
      rank += found;
      found += sum;
      std::uint32_t kept = 0;
      for (; bits != 0 && rank < capacity; ++rank) {
        const std::uint32_t lowest = bits & (0U - bits);
        places[rank] = word * kWarp + __ffs(static_cast<int>(bits)) - 1;
        kept |= lowest;
        bits ^= lowest;
      }
      if (bits != 0) {
        touched[word] = kept;
      }
    }
    const Index kept = found < capacity ? found : capacity;
    all += kept;
    dropped += found - kept;
    if (threadIdx.x == 0) {
      tools.contact_counts[pusher] = kept;
    }
  }
  if (threadIdx.x == 0) {
    input->sums.contacts = all;
    input->sums.dropped_contacts.at_vertices += dropped;
  }
}

__global__ void __launch_bounds__(kToolThreads)
    find(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const Index place = thread_index();
  const bool is_vertex = place < count;
  const Particle p = is_vertex ? load_particle(moving_of(state) + place) : Particle{0, 0, 0, 0};
  const Vec3<float> x = is_vertex ? base_of(state, place) + position_of(p) : Vec3<float>{};
  const PusherInput* const pushers =
      table<PusherInput>(input, input->pushers) + row_at(substep, input->pusher_count);
  const PlacedCapsule* const capsules =
      table<PlacedCapsule>(input, input->capsules) + row_at(substep, input->capsule_count);
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    ContactSearch search;
    if (p.w > 0 && pushers[pusher].box.contains(x)) {
      const Index first = pushers[pusher].first_capsule;
      const Index last = first + pushers[pusher].capsule_count;
      for (Index c = first; c < last; ++c) {
        search.add(load_constant(capsules + c), x);
      }
    }
    if (search.has_contact()) {
      const std::size_t slot = row_at(pusher, state.capacity) + static_cast<std::size_t>(place);
      tools.planes[slot] = search.plane;
      tools.contact_multipliers[slot] = 0;
      const auto& [normal, offset] = search.plane;
      tools.contact_points[slot] = x + (offset - dot(normal, x)) * normal;
    }
    const std::uint32_t bits = __ballot_sync(~0U, search.has_contact());
    if (threadIdx.x % kWarp == 0 && place < state.capacity) {  // none where there is but room
      tools.touched[row_at(pusher, tools.word_count) + static_cast<std::size_t>(place / kWarp)] =
          bits;
    }
  }
  if (is_last_block(&input->sums.blocks_done)) {
    keep_contacts(tools, input);
  }
}

void find_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                   Index substep, const Launch& how) {
  launch(how, "launching the search for contacts", blocks_for(state.capacity, kToolThreads),
         kToolThreads, find, state, tools, input, substep);
}

/// All that hold a vertex, one after another.
/// @param h         of the vertices held
/// @param is_first  of the sweeps of a substep
/// @param p         that moves
/// @param base      m, from where it counts
__device__ inline Particle pull(const ToolArrays& tools, StepInput* input, Index substep,
                                bool is_first, Index h, const Particle& p,
                                const Vec3<float>& base) {
  const AttachmentInput* const attachments =
      table<AttachmentInput>(input, input->attachments) + row_at(substep, input->attachment_count);
  const Index* const order = table<Index>(input, input->held_order);
  const HeldInput vertex = load_constant(table<HeldInput>(input, input->held) + h);
  Vec3<float> x = position_of(p);
  for (Index i = vertex.first; i < vertex.first + vertex.count; ++i) {
    const Index a = order[i];
    const AttachmentInput attachment = load_constant(attachments + a);
    Vec3<float> multiplier{};
    if (!is_first) {
      multiplier = tools.attachment_multipliers[a];
    }
    AttachmentConstraint::project<ProjectionMode::compliance>(
        x, p.w, attachment.target - base, attachment.compliance * input->substep.inverse_dt_squared,
        multiplier);
    tools.attachment_multipliers[a] = multiplier;
  }
  return {x.x, x.y, x.z, p.w};
}

__global__ void __launch_bounds__(kToolThreads)
    pull_held(DeviceState state, ToolArrays tools, StepInput* input, Index substep, bool is_first) {
  wait_for_previous();
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  for (Index h = thread_index(); h < input->held_count; h += thread_count()) {
    const Index place = table<HeldInput>(input, input->held)[h].place;
    Particle* const p = moving_of(state) + place;
    const Particle moved =
        pull(tools, input, substep, is_first, h, load_particle(p), base_of(state, place));
    store_particle(p, position_of(moved), moved.w);
  }
}

void project_attachments(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                         Index substep, bool is_first, const Launch& how) {
  launch(how, "launching the phases of grasps", share_blocks(kHeldBlocks, 1, how), kToolThreads,
         pull_held, state, tools, input, substep, is_first);
}

__device__ inline bool touches(const ToolArrays& tools, Index pusher, Index place) {
  const std::size_t word =
      row_at(pusher, tools.word_count) + static_cast<std::size_t>(place / kWarp);
  return (__ldcg(tools.touched + word) >> (place % kWarp) & 1U) != 0;
}

/// All that touch a vertex, one after another; the last two as pull().
__device__ inline Particle push(const ToolArrays& tools, const StepInput* input, Index place,
                                Index place_room, Particle p, const Vec3<float>& base) {
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    if (!touches(tools, pusher, place)) {
      continue;
    }
    const std::size_t slot = row_at(pusher, place_room) + static_cast<std::size_t>(place);
    const CapsulePlane plane = tools.planes[slot];
    Vec3<float> x = position_of(p);
    ContactConstraint::project(x, p.w, plane.normal, plane.offset - dot(plane.normal, base),
                               tools.contact_multipliers[slot]);
    p = {x.x, x.y, x.z, p.w};
  }
  return p;
}

__global__ void __launch_bounds__(kToolThreads)
    push_touched(DeviceState state, ToolArrays tools, const StepInput* input) {
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const Index place = thread_index();
  if (place >= count) {
    return;
  }
  bool is_touched = false;
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    is_touched |= touches(tools, pusher, place);
  }
  if (is_touched) {
    Particle* const p = moving_of(state) + place;
    const Particle moved =
        push(tools, input, place, state.capacity, load_particle(p), base_of(state, place));
    store_particle(p, position_of(moved), moved.w);
  }
}

void project_contacts(const DeviceState& state, const ToolArrays& tools, const StepInput* input,
                      const Launch& how) {
  launch(how, "launching the phases of contacts", blocks_for(state.capacity, kToolThreads),
         kToolThreads, push_touched, state, tools, input);
}

/// Takes forces on tissue off the wrench of a tool, but for those that are not finite, as a vertex
/// that is lost has them. They are computed side by side and added one after another: the sum is
/// that of one processor. All threads of a block.
/// @param at  (i, force, point) sets them, in N and m
template <int kThreads, class At>
__device__ void feel(Wrench& wrench, const Vec3<float>& origin, Index count, const At& at) {
  __shared__ float parts[6][kThreads];
  static_assert(sizeof(Wrench) == sizeof(float[6]));
  float* const sums = reinterpret_cast<float*>(&wrench);
  float sum = threadIdx.x < 6 ? sums[threadIdx.x] : 0;
  for (Index first = 0; first < count; first += kThreads) {
    const Index i = first + static_cast<Index>(threadIdx.x);
    if (i < count) {
      Vec3<float> force, point;
      at(i, force, point);
      const bool is_felt = is_finite(force) && is_finite(point);
      const Vec3<float> torque = is_felt ? cross(point - origin, force) : Vec3<float>{};
      const float all[6] = {is_felt ? force.x : 0,
                            is_felt ? force.y : 0,
                            is_felt ? force.z : 0,
                            torque.x,
                            torque.y,
                            torque.z};
      for (int k = 0; k < 6; ++k) {
        parts[k][threadIdx.x] = all[k];
      }
    }
    __syncthreads();
    if (threadIdx.x < 6) {
      const Index some = count - first < kThreads ? count - first : kThreads;
      for (Index k = 0; k < some; ++k) {
        sum -= parts[threadIdx.x][k];
      }
    }
    __syncthreads();
  }
  if (threadIdx.x < 6) {
    sums[threadIdx.x] = sum;
  }
}

/// Where the origin of a tool's frame is, m.
/// @param meeter  that it is, or kInvalidIndex
__device__ inline Vec3<float> origin_of(StepInput* input, Index substep, Index tool,
                                        const SurfaceArrays& surfaces, Index meeter) {
  const Vec3<float> origin =
      (table<Vec3<float>>(input, input->origins) + row_at(substep, input->tool_count))[tool];
  return meeter == kInvalidIndex ? origin : origin + surfaces.springs[meeter].displacement;
}

/// A block a tool.
__global__ void __launch_bounds__(kToolThreads)
    collect(ToolArrays tools, StepInput* input, Index place_room, Index substep) {
  wait_for_previous();
  tools = of_copy(tools, place_room);
  const SurfaceArrays& surfaces = tools.surfaces;
  input += copy_index();
  const float scale = input->force_per_multiplier;
  for (Index t = static_cast<Index>(blockIdx.x); t < input->tool_count;
       t += static_cast<Index>(gridDim.x)) {
    const ToolInput tool = table<ToolInput>(input, input->tools)[t];
    Wrench& wrench = table<Wrench>(input, input->wrenches)[t];
    const Vec3<float> origin = origin_of(input, substep, t, surfaces, tool.meeter);
    if (tool.pusher != kInvalidIndex) {
      const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
        const Index place = tools.contact_places[row_at(tool.pusher, tools.contact_room) +
                                                 static_cast<std::size_t>(i)];
        const std::size_t slot = row_at(tool.pusher, place_room) + static_cast<std::size_t>(place);
        force = (scale * tools.contact_multipliers[slot]) * tools.planes[slot].normal;
        point = tools.contact_points[slot];
      };
      feel<kToolThreads>(wrench, origin, tools.contact_counts[tool.pusher], at);
    } else if (tool.meeter != kInvalidIndex) {
      const Index first = surfaces.ends[tool.meeter];
      const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
        const SurfaceContact& contact = surfaces.contacts[first + i].contact;
        force = scale * (contact.multiplier * contact.normal + contact.friction);
        point = contact.point;
      };
      feel<kToolThreads>(wrench, origin, surfaces.ends[tool.meeter + 1] - first, at);
    } else if (tool.grip != kInvalidIndex) {
      const GripInput& grip = table<GripInput>(input, input->grips)[tool.grip];
      const GripPointInput* const points =
          table<GripPointInput>(input, input->grip_points) + grip.first_point;
      const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
        force = scale * points[i].multiplier;
        point = points[i].target + grip.slide;
      };
      feel<kToolThreads>(wrench, origin, grip.point_count, at);
    } else {
      const AttachmentInput* const attachments = table<AttachmentInput>(input, input->attachments) +
                                                 row_at(substep, input->attachment_count) +
                                                 tool.first_attachment;
      const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
        force = scale * tools.attachment_multipliers[tool.first_attachment + i];
        point = attachments[i].target;
      };
      feel<kToolThreads>(wrench, origin, tool.attachment_count, at);
    }
    __syncthreads();
  }
}

void collect_forces(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                    Index substep, const Launch& how) {
  launch(how, "launching the sum of forces", share_blocks(kForceBlocks, 1, how), kToolThreads,
         collect, tools, input, state.capacity, substep);
}

/// What a contact pushes does not spring back, of BDF2.
__device__ inline void ease_vertex(const DeviceState& state, Index place, const Vec3<float>& normal,
                                   float inverse_h) {
  const Pushed<float> now = eased<float>(
      {load_velocity(state.velocities + place), load_velocity(state.velocities_before + place)},
      normal, load_way(state.ways + place), inverse_h);
  store_velocity(state.velocities + place, now.velocity);
  store_velocity(state.velocities_before + place, now.velocity_before);
}

/// One tool after another, as on the host, for one may push a vertex that another does: one block.
__global__ void __launch_bounds__(kToolThreads)
    ease(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    const Index* const places = tools.contact_places + row_at(pusher, tools.contact_room);
    const Index count = tools.contact_counts[pusher];
    for (Index i = static_cast<Index>(threadIdx.x); i < count; i += kToolThreads) {
      const Index place = places[i];
      const std::size_t slot = row_at(pusher, state.capacity) + static_cast<std::size_t>(place);
      if (tools.contact_multipliers[slot] > 0) {
        ease_vertex(state, place, tools.planes[slot].normal, input->inverse_h);
      }
    }
    __syncthreads();
  }
}

void ease_contacts(const DeviceState& state, const ToolArrays& tools, const StepInput* input,
                   const Launch& how) {
  launch(how, "launching the easing of contacts", 1, kToolThreads, ease, state, tools, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
