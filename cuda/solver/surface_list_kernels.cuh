// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces in the order of the host's lists, with what sweeps need to find theirs.
/// One block a copy.

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <cub/block/block_scan.cuh>

#include "cuda/solver/contact_crew.cuh"
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
  DeviceContact* const all = surfaces.found + row_at(m, surfaces.tool_room);
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

/// What ordering contacts and their holds reads again and again, in one piece of memory.
struct ContactLists {
  ContactKey* keys;         ///< of those found
  ContactKey* sorted_keys;  ///< [contact]
  HoldKey* hold_keys;       ///< [hold]
  HoldKey* sorted_holds;    ///< [hold] place by place, the last first
  Index* slots;             ///< where those found lie in SurfaceArrays::found
  Index* order;             ///< [contact] its slot
  Index* levels;            ///< [contact] as in SurfaceArrays
  float* weights;           ///< [hold] negative if its contact is at rest
  float* sorted_weights;    ///< as sorted_holds
  Index* ranks;             ///< of contacts, then of holds
  /// [hold] the contact of the one before at its place, or kInvalidIndex; where ranks were
  Index* befores;

  /// @param room  contacts
  __device__ ContactLists(unsigned char* memory, Index room) {
    const auto take = [&](auto*& list, Index count) {
      list = reinterpret_cast<std::remove_reference_t<decltype(list)>>(memory);
      memory += static_cast<std::size_t>(count) * sizeof(*list);
    };
    take(keys, room);
    take(sorted_keys, room);
    take(hold_keys, 3 * room);
    take(sorted_holds, 3 * room);
    take(slots, room);
    take(order, room);
    take(levels, room);
    take(weights, 3 * room);
    take(sorted_weights, 3 * room);
    take(ranks, 3 * room);
    befores = ranks;
  }
};

/// Near at hand: of so many contacts at most.
struct ListStage {
  static constexpr Index kRoom = 320;
  alignas(16) unsigned char memory[kRoom * kListBytes];
};

/// Tools and features in their order.
struct OrderOfContact {
  std::uint64_t high, low;

  __device__ explicit OrderOfContact(const ContactKey& key)
      : high(pair(key.meeter, key.feature.places[0])),
        low(pair(key.feature.places[1], key.feature.places[2])) {}

  [[nodiscard]] __device__ bool operator==(const OrderOfContact& other) const {
    return high == other.high && low == other.low;
  }
  [[nodiscard]] __device__ bool operator<(const OrderOfContact& other) const {
    return high < other.high || (high == other.high && low < other.low);
  }

 private:
  /// kInvalidIndex comes before all others.
  __device__ static std::uint64_t pair(Index first, Index second) {
    return std::uint64_t{static_cast<std::uint32_t>(first + 1)} << 32 |
           static_cast<std::uint32_t>(second + 1);
  }
};

/// Places, and holds of each, the last first.
__device__ inline HoldKey key_of_hold(Index place, Index hold) {
  return HoldKey{static_cast<std::uint32_t>(place)} << 32 | ~static_cast<std::uint32_t>(hold);
}
__device__ inline Index place_of(HoldKey key) {
  return static_cast<Index>(static_cast<std::uint32_t>(key >> 32));
}
__device__ inline Index hold_of(HoldKey key) {
  return static_cast<Index>(~static_cast<std::uint32_t>(key));
}

/// Counts, for each of some things, those that come before it. All threads of a block call it, and
/// are to meet before they read it.
/// @tparam kThreads   of the block
/// @param  is_before  (j, i)
template <int kThreads = kListThreads, class IsBefore>
__device__ inline void rank_all(Index count, Index* ranks, const IsBefore& is_before) {
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index i = thread; i < count; i += kThreads) {
    ranks[i] = 0;
  }
  __syncthreads();
  const Index parts = count < kThreads ? kThreads / (count > 0 ? count : 1) : 1;
  for (Index t = thread; t < parts * count; t += kThreads) {
    const Index i = t % count;
    Index before = 0;
#pragma unroll 4
    for (Index j = t / count; j < count; j += parts) {
      before += is_before(j, i) ? 1 : 0;
    }
    if (before > 0) {
      atomicAdd(ranks + i, before);
    }
  }
}

/// Puts contacts in the order of tools and features, each once.
/// @param count  of those found
/// @return       of those kept
__device__ inline Index sort_contacts(const ContactLists& lists, Index count) {
  using Scan = cub::BlockScan<Index, kListThreads>;
  __shared__ typename Scan::TempStorage storage;
  const auto thread = static_cast<Index>(threadIdx.x);
  bool is_any_again = false;
  rank_all(count, lists.ranks, [&](Index j, Index i) {
    const OrderOfContact own(lists.keys[i]), other(lists.keys[j]);
    const bool is_again = j < i && other == own;
    is_any_again |= is_again;
    return other < own || is_again;
  });
  __syncthreads();
  for (Index i = thread; i < count; i += kListThreads) {
    lists.sorted_keys[lists.ranks[i]] = lists.keys[i];
    lists.order[lists.ranks[i]] = lists.slots[i];
  }
  if (__syncthreads_or(is_any_again) == 0) {
    return count;
  }
  Index kept = 0;
  for (Index first = 0; first < count; first += kListThreads) {
    const Index i = first + thread;
    ContactKey own{};
    Index slot = 0;
    const bool is_kept = i < count && (i == 0 || !(OrderOfContact(lists.sorted_keys[i - 1]) ==
                                                   OrderOfContact(lists.sorted_keys[i])));
    if (is_kept) {
      own = lists.sorted_keys[i];
      slot = lists.order[i];
    }
    Index rank = 0, sum = 0;
    Scan(storage).ExclusiveSum(is_kept ? 1 : 0, rank, sum);
    __syncthreads();
    if (is_kept) {
      lists.sorted_keys[kept + rank] = own;
      lists.order[kept + rank] = slot;
    }
    kept += sum;
    __syncthreads();
  }
  return kept;
}

/// Lists the holds of each place. All threads of a block call it, and meet in it.
/// @param count  of contacts
__device__ inline void list_holds(const SurfaceArrays& surfaces, const ContactLists& lists,
                                  Index count) {
  const auto thread = static_cast<Index>(threadIdx.x);
  const Index holds = 3 * count;
  for (Index hold = thread; hold < holds; hold += kListThreads) {
    lists.hold_keys[hold] = key_of_hold(lists.sorted_keys[hold / 3].feature.places[hold % 3], hold);
  }
  rank_all(holds, lists.ranks,
           [&](Index j, Index i) { return lists.hold_keys[j] < lists.hold_keys[i]; });
  __syncthreads();
  for (Index hold = thread; hold < holds; hold += kListThreads) {
    const Index rank = lists.ranks[hold];
    lists.sorted_holds[rank] = lists.hold_keys[hold];
    lists.sorted_weights[rank] = lists.weights[hold];
  }
  __syncthreads();
  for (Index i = thread; i < holds; i += kListThreads) {
    const HoldKey key = lists.sorted_holds[i];
    const Index place = place_of(key), hold = hold_of(key);
    lists.befores[hold] = kInvalidIndex;
    if (place == kInvalidIndex) {
      continue;
    }
    const auto is_here = [&](Index other) {
      return other >= 0 && other < holds && place_of(lists.sorted_holds[other]) == place;
    };
    Index first = i, end = i + 1;
    while (is_here(first - 1)) {
      --first;
    }
    // its own push, even if that is not likely; others in the order of their holds
    float pushes = lists.sorted_weights[i] > 0 ? 0.0F : -lists.sorted_weights[i];
    for (end = first; is_here(end); ++end) {
      const float weight = lists.sorted_weights[end];
      pushes += weight > 0 ? weight : 0.0F;
    }
    if (i + 1 < end) {
      lists.befores[hold] = hold_of(lists.sorted_holds[i + 1]) / 3;
    }
    surfaces.holds[i] = hold;
    surfaces.roots[hold] = hold_of(lists.sorted_holds[end - 1]);
    surfaces.pushes[hold] = pushes;
    if (i == first) {
      surfaces.holds_at[place] = {first, end - first};
    }
  }
  __syncthreads();
}

/// Whether a feature is among contacts, which are in its order.
__device__ inline bool is_met(const DeviceContact* contacts, Index count,
                              const ContactFeature& feature) {
  Index low = 0, high = count;
  while (low < high) {
    const Index middle = (low + high) / 2;
    const int order = compare(contacts[middle].contact.feature, feature);
    if (order == 0) {
      return true;
    }
    low = order < 0 ? middle + 1 : low;
    high = order < 0 ? high : middle;
  }
  return false;
}

/// Of all contacts that are not met any more; the order is that of what the substep before left.
__device__ inline void hand_over(const SurfaceArrays& surfaces, const Meeters& meeters,
                                 Index meeter_count, float inverse_dt_squared) {
  const auto thread = static_cast<Index>(threadIdx.x);
  // what an edit has left of the room may be less
  const auto end_of = [&](const Meeters::Range& range) {
    const Index end = range.first + range.count;
    return end < surfaces.contact_room ? end : surfaces.contact_room;
  };
  for (Index m = 0; m < meeter_count; ++m) {
    const Meeters::Range range = meeters.range(m);
    const Index begin = surfaces.ends[m], end = surfaces.ends[m + 1];
    for (Index r = range.first + thread; r < end_of(range); r += kListThreads) {
      const RememberedContact gone = meeters.remembered[r];
      HandedForce handed;
      if (gone.force > 0 && !is_met(surfaces.contacts + begin, end - begin, gone.feature)) {
        for (Index c = begin; c < end; ++c) {
          handed.consider(gone, surfaces.contacts[c].contact, c);
        }
      }
      surfaces.handed[r] = handed;
    }
  }
  __syncthreads();
  for (Index m = 0; m < meeter_count; ++m) {
    const Meeters::Range range = meeters.range(m);
    for (Index c = surfaces.ends[m] + thread; c < surfaces.ends[m + 1]; c += kListThreads) {
      SurfaceContact& contact = surfaces.contacts[c].contact;
      for (Index r = range.first; contact.takes_over && r < end_of(range); ++r) {
        const HandedForce handed = surfaces.handed[r];
        if (handed.taker == c) {
          contact.multiplier += handed.share * meeters.remembered[r].force / inverse_dt_squared;
        }
      }
    }
  }
  __syncthreads();
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
  __shared__ ListStage stage;
  const bool is_staged = count <= ListStage::kRoom;
  const ContactLists lists(is_staged ? stage.memory : surfaces.list_memory,
                           is_staged ? ListStage::kRoom : surfaces.contact_room);
  __syncthreads();
  for (Index i = thread; i < count; i += kListThreads) {
    Index meeter = 0, rank = i;
    for (Index m = 0; m < input->meeter_count; ++m) {  // to the end, so that none waits for another
      const Index met = __ldcg(surfaces.met_counts + m);
      const Index taken = met < capacity ? met : capacity;
      const bool is_beyond = m == meeter && rank >= taken;
      rank -= is_beyond ? taken : 0;
      meeter += is_beyond ? 1 : 0;
    }
    const Index slot = meeter * surfaces.tool_room + rank;
    lists.slots[i] = slot;
    lists.keys[i] = {surfaces.found[slot].contact.feature, meeter};
  }
  __syncthreads();
  const Index kept = sort_contacts(lists, count);
  for (Index c = thread; c < kept; c += kListThreads) {
    surfaces.contacts[c] = surfaces.found[lists.order[c]];
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
  if (remembers) {
    hand_over(surfaces, meeters, input->meeter_count, inverse_dt_squared);
  }
  for (Index c = thread; c < kept; c += kListThreads) {
    const DeviceContact& contact = surfaces.contacts[c];
    const bool is_likely =
        contact.contact.multiplier > 0 || read_contact(state, surfaces, contact).gap < 0;
    for (int k = 0; k < 3; ++k) {
      lists.weights[3 * c + k] =
          is_likely ? contact.contact.weights[k] : -contact.contact.weights[k];
    }
  }
  __syncthreads();
  for (Index m = thread; m < input->meeter_count; m += kListThreads) {
    surfaces.met_counts[m] = 0;
  }
  if (thread == 0) {
    input->sums.contacts = (has_pushers ? input->sums.contacts : 0) + kept;
    input->sums.dropped_contacts.at_surfaces += dropped;
  }
  list_holds(surfaces, lists, kept);
  if (thread < kWarp) {
    const Index levels = find_levels(kept, lists.levels, [&](Index c, Index(&befores)[4]) {
      for (int k = 0; k < 3; ++k) {
        befores[k] = lists.befores[3 * c + k];
      }
      const Index meeter = lists.sorted_keys[c].meeter;  // whose spring all of its contacts share
      if (c > 0 && lists.sorted_keys[c - 1].meeter == meeter &&
          meeters.meeters[meeter].compliance > 0) {
        befores[3] = c - 1;
      }
    });
    if (thread == 0) {
      *surfaces.level_counts = levels;
    }
  }
  __syncthreads();
  for (Index c = thread; c < kept; c += kListThreads) {
    surfaces.levels[c] = lists.levels[c];
  }
}

void find_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                           Index substep, bool has_pushers, const Launch& how) {
  const bool remembers = state.fixed_points != nullptr && !state.starts;
  const SurfaceArrays& surfaces = tools.surfaces;
  const Index items = surfaces.candidate_room - (kFeaturesOfTriangle - 1) * surfaces.triangle_count;
  launch(how, "launching the search for surfaces",
         blocks_for(items, NearCandidates::kItems) * surfaces.meeter_room, kSearchThreads,
         meet_candidates, state, tools, input, substep, remembers);
  launch(how, "launching the list of contacts", 1, kListThreads, list_contacts, state, tools, input,
         substep, has_pushers, remembers);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
