// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces in the order of the host's lists, with what sweeps need to find theirs.
/// One block a copy.

#include <cub/block/block_scan.cuh>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/surface_contact.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kListThreads = 256;

/// Where a tool met more candidates than there is room for: finds the first of them again. Rare, so
/// not among the instructions of what is not.
__device__ __noinline__ void find_first(const DeviceState& state, const SurfaceArrays& surfaces,
                                        const Meeters& meeters, Index m, Index capacity,
                                        Index vertices, float inverse_dt_squared, bool remembers) {
  using Scan = cub::BlockScan<Index, kListThreads>;
  __shared__ typename Scan::TempStorage storage;
  DeviceContact* const all = surfaces.found + of_pusher(m, surfaces.tool_room);
  Index count = 0;
  for (Index first = 0; first < surfaces.candidate_room && count < capacity;
       first += kListThreads) {
    DeviceContact found;
    const bool is_met =
        find_contact(state, surfaces, meeters, m, first + static_cast<Index>(threadIdx.x), vertices,
                     inverse_dt_squared, remembers, found);
    Index rank = 0, sum = 0;
    Scan(storage).ExclusiveSum(is_met ? 1 : 0, rank, sum);
    if (is_met && count + rank < capacity) {
      all[count + rank] = found;
    }
    count += sum;
    __syncthreads();
  }
}

/// Of contacts, what ordering and chaining read again and again.
struct ContactLists {
  ContactKey* keys;         ///< of those found
  ContactKey* sorted_keys;  ///< [contact]
  Index* order;             ///< [contact] which of those found it is
  Index* next_holds;        ///< as in SurfaceArrays, like the rest
  float* likely_weights;
  Index* levels;
};

/// Near at hand: of so many contacts at most.
struct ListStage {
  static constexpr Index kRoom = 512;
  ContactKey keys[kRoom], sorted_keys[kRoom];
  Index order[kRoom], next_holds[3 * kRoom];
  float likely_weights[3 * kRoom];
  Index levels[kRoom];
};

__device__ inline bool is_before(const ContactKey& a, const ContactKey& b) {
  return a.meeter < b.meeter || (a.meeter == b.meeter && compare(a.feature, b.feature) < 0);
}

/// Puts contacts in the order of tools and features, each once.
/// @param count  of those found
/// @return       of those kept
__device__ inline Index sort_contacts(const ContactLists& lists, Index count) {
  using Scan = cub::BlockScan<Index, kListThreads>;
  __shared__ typename Scan::TempStorage storage;
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index i = thread; i < count; i += kListThreads) {
    const ContactKey own = lists.keys[i];
    Index rank = 0;
    for (Index j = 0; j < count; ++j) {
      const ContactKey other = lists.keys[j];
      rank += is_before(other, own) || (j < i && !is_before(own, other)) ? 1 : 0;
    }
    lists.sorted_keys[rank] = own;
    lists.order[rank] = i;
  }
  __syncthreads();
  Index kept = 0;
  for (Index first = 0; first < count; first += kListThreads) {
    const Index i = first + thread;
    ContactKey own{};
    Index source = 0;
    bool is_kept = false;
    if (i < count) {
      own = lists.sorted_keys[i];
      source = lists.order[i];
      is_kept = i == 0 || is_before(lists.sorted_keys[i - 1], own);
    }
    Index rank = 0, sum = 0;
    Scan(storage).ExclusiveSum(is_kept ? 1 : 0, rank, sum);
    __syncthreads();
    if (is_kept) {
      lists.sorted_keys[kept + rank] = own;
      lists.order[kept + rank] = source;
    }
    kept += sum;
    __syncthreads();
  }
  return kept;
}

/// Chains the holds of each place, the last first.
/// @param count  of contacts
__device__ inline void chain_holds(const SurfaceArrays& surfaces, const ContactLists& lists,
                                   Index count) {
  for (Index hold = static_cast<Index>(threadIdx.x); hold < 3 * count; hold += kListThreads) {
    const Index own = hold / 3;
    const Index place = lists.sorted_keys[own].feature.places[hold % 3];
    Index last = hold, before = kInvalidIndex, root = hold;
    // its own push, even if that is not likely; others in the order of their holds
    float pushes =
        lists.likely_weights[hold] > 0 ? 0.0F : surfaces.contacts[own].contact.weights[hold % 3];
    for (Index c = place == kInvalidIndex ? 0 : count; c-- > 0;) {
      const ContactFeature& feature = lists.sorted_keys[c].feature;
#pragma unroll
      for (int k = 0; k < 3; ++k) {
        if (feature.places[k] == place) {
          const Index other = 3 * c + k;
          pushes += lists.likely_weights[other];
          last = other > last ? other : last;
          before = other < hold && before == kInvalidIndex ? other : before;
          root = other;
        }
      }
    }
    lists.next_holds[hold] = before;
    surfaces.next_holds[hold] = before;
    surfaces.roots[hold] = root;
    surfaces.pushes[hold] = pushes;
    if (place != kInvalidIndex && last == hold) {
      surfaces.first_holds[place] = hold;
    }
  }
}

/// Finds the levels of contacts from the chains of their holds.
/// @return  how many there are
__device__ inline Index find_levels(const SurfaceArrays& surfaces, const ContactLists& lists,
                                    Index count) {
  constexpr Index kUnknown = -1;
  const auto thread = static_cast<Index>(threadIdx.x);
  volatile Index* const levels = lists.levels;
  __shared__ Index level_count;
  if (thread == 0) {
    level_count = 0;
  }
  for (Index c = thread; c < count; c += kListThreads) {
    levels[c] = kUnknown;
  }
  bool is_any_unknown = count > 0;
  while (is_any_unknown) {
    __syncthreads();
    is_any_unknown = false;
    for (Index c = thread; c < count; c += kListThreads) {
      if (levels[c] != kUnknown) {
        continue;
      }
      Index level = 0;
      const auto come_after = [&](Index other) {
        const Index known = levels[other];
        level = known == kUnknown || level == kUnknown ? kUnknown
                                                       : (known + 1 > level ? known + 1 : level);
      };
      for (int k = 0; k < 3; ++k) {
        const Index before = lists.next_holds[3 * c + k];
        if (before != kInvalidIndex) {
          come_after(before / 3);
        }
      }
      const Index spring = surfaces.contacts[c].spring;
      if (spring != kInvalidIndex && c > 0 && surfaces.contacts[c - 1].spring == spring) {
        come_after(c - 1);
      }
      levels[c] = level;
      atomicMax(&level_count, level + 1);
      is_any_unknown |= level == kUnknown;
    }
    is_any_unknown = __syncthreads_or(is_any_unknown) != 0;
  }
  __syncthreads();
  for (Index c = thread; c < count; c += kListThreads) {
    surfaces.levels[c] = levels[c];
  }
  return level_count;
}

/// One block a copy.
/// @param has_pushers  then other contacts have been counted
__global__ void __launch_bounds__(kListThreads)
    list_contacts(DeviceState state, ToolArrays tools, StepInput* input, Index substep,
                  bool has_pushers, bool remembers) {
  const Index vertices = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  const Meeters meeters(surfaces, input, substep);
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Index before = surfaces.ends[surfaces.meeter_room];
  for (Index hold = thread; hold < 3 * before; hold += kListThreads) {
    const Index place = surfaces.contacts[hold / 3].contact.feature.places[hold % 3];
    if (place != kInvalidIndex) {
      surfaces.first_holds[place] = kInvalidIndex;
    }
  }
  const Index capacity =
      input->contact_capacity < surfaces.tool_room ? input->contact_capacity : surfaces.tool_room;
  Index count = 0, dropped = 0;
  for (Index m = 0; m < input->meeter_count; ++m) {
    const Index met = __ldcg(surfaces.met_counts + m);
    if (met > capacity) {
      find_first(state, surfaces, meeters, m, capacity, vertices, inverse_dt_squared, remembers);
      dropped += met - capacity;
    }
    count += met < capacity ? met : capacity;
  }
  for (Index m = thread; m < input->meeter_count; m += kListThreads) {
    ToolSpring spring{meeters.displacement(surfaces, m), {}, 0};
    if (meeters.meeters[m].compliance > 0) {
      begin_spring(meeters.meeters[m].compliance, inverse_dt_squared, remembers, spring);
    }
    surfaces.springs[m] = spring;
  }
  __shared__ SharedRoom<ListStage> room;
  ListStage& stage = room.get();
  const bool is_staged = count <= ListStage::kRoom;
  const ContactLists lists =
      is_staged ? ContactLists{stage.keys,       stage.sorted_keys,    stage.order,
                               stage.next_holds, stage.likely_weights, stage.levels}
                : ContactLists{surfaces.keys,       surfaces.sorted_keys,    surfaces.order,
                               surfaces.next_holds, surfaces.likely_weights, surfaces.levels};
  const auto found_at = [&](Index i, Index& m) -> const DeviceContact& {
    m = 0;
    for (Index met = 0;; ++m, i -= met) {
      met = __ldcg(surfaces.met_counts + m);
      met = met < capacity ? met : capacity;
      if (i < met) {
        return surfaces.found[of_pusher(m, surfaces.tool_room) + static_cast<std::size_t>(i)];
      }
    }
  };
  __syncthreads();
  for (Index i = thread; i < count; i += kListThreads) {
    Index m = 0;
    const ContactFeature& feature = found_at(i, m).contact.feature;
    lists.keys[i] = {feature, m};
  }
  __syncthreads();
  const Index kept = sort_contacts(lists, count);
  for (Index c = thread; c < kept; c += kListThreads) {
    Index m = 0;
    const DeviceContact contact = found_at(lists.order[c], m);
    surfaces.contacts[c] = contact;
    const bool is_likely =
        contact.contact.multiplier > 0 || read_contact(state, surfaces, contact).gap < 0;
    for (int k = 0; k < 3; ++k) {
      lists.likely_weights[3 * c + k] = is_likely ? contact.contact.weights[k] : 0.0F;
    }
  }
  // where the contacts of each meeter begin
  for (Index c = thread; c <= kept; c += kListThreads) {
    const Index first = c == 0 ? 0 : lists.sorted_keys[c - 1].meeter + 1;
    const Index last = c == kept ? surfaces.meeter_room : lists.sorted_keys[c].meeter;
    for (Index m = first; m <= last; ++m) {
      surfaces.ends[m] = c;
    }
  }
  __syncthreads();
  for (Index m = thread; m < input->meeter_count; m += kListThreads) {
    surfaces.met_counts[m] = 0;
  }
  if (thread == 0) {
    input->sums.contacts = (has_pushers ? input->sums.contacts : 0) + kept;
    input->sums.dropped_contacts += dropped;
  }
  chain_holds(surfaces, lists, kept);
  __syncthreads();
  const Index levels = find_levels(surfaces, lists, kept);
  if (thread == 0) {
    *surfaces.level_counts = levels;
  }
}

void find_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                           Index substep, bool has_pushers, const Launch& how) {
  const bool remembers = state.fixed_points != nullptr && !state.starts;
  const SurfaceArrays& surfaces = tools.surfaces;
  launch(how, "launching the search for surfaces",
         blocks_for(surfaces.candidate_room, kToolThreads) * surfaces.meeter_room, kToolThreads,
         meet_candidates, state, tools, input, substep, remembers);
  launch(how, "launching the list of contacts", 1, kListThreads, list_contacts, state, tools, input,
         substep, has_pushers, remembers);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
