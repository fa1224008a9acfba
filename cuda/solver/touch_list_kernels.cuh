// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts between bodies in the order of the host's list, with what sweeps need to find theirs.
/// One block a copy.

#include <cstddef>
#include <cstdint>

#include <cub/block/block_merge_sort.cuh>
#include <cub/block/block_scan.cuh>

#include "cuda/solver/surface_list_kernels.cuh"
#include "cuda/solver/touch_contact.cuh"
#include "cuda/solver/touch_search_kernels.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kTouchListThreads = 512;

/// Flags that a thread reads at a time.
constexpr Index kFlagsOfThread = sizeof(uint4);

/// Lists what vertices have met, in their order.
/// @param room  of the list
/// @return      how many they have met
__device__ inline Index list_met(const TouchArrays& touches, Index room) {
  using Scan = cub::BlockScan<Index, kTouchListThreads>;
  __shared__ typename Scan::TempStorage storage;
  Index count = 0;
  for (Index first = 0; first < touches.vertex_count; first += kTouchListThreads * kFlagsOfThread) {
    const Index own = first + static_cast<Index>(threadIdx.x) * kFlagsOfThread;
    union {
      uint4 words;
      std::uint8_t flags[kFlagsOfThread];
    } met{};
    if (own < touches.vertex_count) {
      met.words = __ldcg(reinterpret_cast<const uint4*>(touches.is_met + own));
    }
    Index of_thread = 0;
    for (const std::uint8_t flag : met.flags) {
      of_thread += flag;
    }
    Index rank = 0, sum = 0;
    Scan(storage).ExclusiveSum(of_thread, rank, sum);
    for (Index i = 0, at = count + rank; of_thread > 0 && i < kFlagsOfThread; ++i) {
      if (met.flags[i] != 0) {
        if (at < room) {
          touches.order[at] = own + i;
        }
        ++at;
      }
    }
    count += sum;
    __syncthreads();
  }
  return count;
}

/// What listing holds has near at hand, of as many contacts as there are threads: each thread has
/// the corners of one.
struct TouchStage {
  static constexpr Index kContacts = kTouchListThreads;
  static constexpr Index kHolds = TissueTouch::kCorners * kContacts;
  using Sort = cub::BlockMergeSort<HoldKey, kTouchListThreads, TissueTouch::kCorners>;

  HoldKey keys[kHolds];  ///< sorted
  union {
    typename Sort::TempStorage sort;
    struct {
      float weights[kHolds];         ///< [hold] negative if its contact is at rest
      float sorted_weights[kHolds];  ///< as keys
      alignas(int4) Index befores[kHolds];
    } lists;
  } room;
  Index levels[kContacts];
};

/// Of sorted keys, the first that does not come before another.
__device__ inline Index first_not_before(const HoldKey (&keys)[TouchStage::kHolds], HoldKey key) {
  Index low = 0, high = TouchStage::kHolds;
  while (low < high) {
    const Index middle = (low + high) / 2;
    low = keys[middle] < key ? middle + 1 : low;
    high = keys[middle] < key ? high : middle;
  }
  return low;
}

/// Lists the holds of each place, the last first. All threads of a block call it.
/// @param touch  the contact of this thread, if it has one
/// @param count  of contacts, at most as many as there are threads
__device__ inline void list_holds(const TouchArrays& touches, const TissueTouch& touch, Index count,
                                  TouchStage& stage) {
  constexpr Index kCorners = TissueTouch::kCorners;
  constexpr HoldKey kNone = ~HoldKey{};
  const Index first_hold = kCorners * static_cast<Index>(threadIdx.x);
  HoldKey keys[kCorners];
#pragma unroll
  for (Index k = 0; k < kCorners; ++k) {
    const bool is_there = first_hold < kCorners * count && touch.weights[k] != 0;
    keys[k] = is_there ? key_of_hold(touch.places[k], first_hold + k) : kNone;
  }
  TouchStage::Sort(stage.room.sort).Sort(keys, [](const HoldKey& a, const HoldKey& b) {
    return a < b;
  });
  __syncthreads();
  float* const weights = stage.room.lists.weights;
#pragma unroll
  for (Index k = 0; k < kCorners; ++k) {
    stage.keys[first_hold + k] = keys[k];
    const float weight = fabsf(touch.weights[k]);
    weights[first_hold + k] = touch.is_likely ? weight : -weight;
    stage.room.lists.befores[first_hold + k] = kInvalidIndex;
  }
  __syncthreads();
  for (Index i = static_cast<Index>(threadIdx.x); i < kCorners * count; i += kTouchListThreads) {
    const HoldKey key = stage.keys[i];
    stage.room.lists.sorted_weights[i] = key == kNone ? 0.0F : weights[hold_of(key)];
  }
  __syncthreads();
  for (Index i = static_cast<Index>(threadIdx.x); i < kCorners * count; i += kTouchListThreads) {
    const HoldKey key = stage.keys[i];
    if (key == kNone) {
      continue;
    }
    const Index place = place_of(key), hold = hold_of(key);
    const Index first = first_not_before(stage.keys, key_of_hold(place, kInvalidIndex));
    // its own push, even if that is not likely; others in the order of their holds
    float pushes = weights[hold] > 0 ? 0.0F : -weights[hold];
    const Index end = first_not_before(stage.keys, key_of_hold(place + 1, kInvalidIndex));
#pragma unroll 8
    for (Index other = first; other < end; ++other) {
      const float weight = stage.room.lists.sorted_weights[other];
      pushes += weight > 0 ? weight : 0.0F;
    }
    if (i + 1 < end) {
      stage.room.lists.befores[hold] = hold_of(stage.keys[i + 1]) / kCorners;
    }
    touches.holds[i] = hold;
    touches.roots[hold] = hold_of(stage.keys[end - 1]);
    touches.pushes[hold] = pushes;
    if (i == first) {
      touches.holds_at[place] = {first, end - first};
    }
  }
  __syncthreads();
}

/// Lists the holds of each place, the last first, of any number of contacts. All threads of a block
/// call it.
/// @param contacts  how many
__device__ inline void list_many_holds(const TouchArrays& touches, Index contacts) {
  const auto thread = static_cast<Index>(threadIdx.x);
  const Index holds = TissueTouch::kCorners * contacts;
  __shared__ Index listed;
  if (thread == 0) {
    listed = 0;
  }
  // chains in any order: what comes before a hold is in roots until these are known
  for (Index hold = thread; hold < holds; hold += kTouchListThreads) {
    const Index place = place_of_corner(touches, hold);
    touches.befores[hold] = kInvalidIndex;
    touches.roots[hold] =
        place == kInvalidIndex ? kInvalidIndex : atomicExch(touches.last_holds + place, hold);
  }
  __syncthreads();
  for (Index hold = thread; hold < holds; hold += kTouchListThreads) {
    const Index place = place_of_corner(touches, hold);
    if (place == kInvalidIndex || __ldcg(touches.last_holds + place) != hold) {
      continue;
    }
    Index count = 0;
    for (Index h = hold; h != kInvalidIndex; h = __ldcg(touches.roots + h)) {
      ++count;
    }
    const Index first = atomicAdd(&listed, count);
    Index* const own = touches.holds + first;
    Index sorted = 0;
    for (Index h = hold; h != kInvalidIndex; h = __ldcg(touches.roots + h)) {
      Index at = sorted++;
      for (; at > 0 && own[at - 1] < h; --at) {
        own[at] = own[at - 1];
      }
      own[at] = h;
    }
    touches.holds_at[place] = {first, count};
    touches.last_holds[place] = kInvalidIndex;
  }
  __syncthreads();
  // threads of a place have read its chain
  for (Index hold = thread; hold < holds; hold += kTouchListThreads) {
    const Index place = place_of_corner(touches, hold);
    if (place == kInvalidIndex) {
      continue;
    }
    const HoldRange range = touches.holds_at[place];
    const Index* const all = touches.holds + range.first;
    const auto weight_of = [&](Index h) {
      return fabsf(touches.contacts[h / TissueTouch::kCorners].weights[h % TissueTouch::kCorners]);
    };
    // its own push, even if that is not likely; others in the order of their holds
    float pushes =
        touches.contacts[hold / TissueTouch::kCorners].is_likely ? 0.0F : weight_of(hold);
    for (Index i = 0; i < range.count; ++i) {
      if (touches.contacts[all[i] / TissueTouch::kCorners].is_likely) {
        pushes += weight_of(all[i]);
      }
      if (all[i] == hold && i + 1 < range.count) {
        touches.befores[hold] = all[i + 1] / TissueTouch::kCorners;
      }
    }
    touches.pushes[hold] = pushes;
    touches.roots[hold] = all[range.count - 1];
  }
  __syncthreads();
}

/// find_levels() of at most as many contacts as the block has threads: each waits for those before
/// it. All threads of a block call it.
/// @param levels  [count] in shared memory
__device__ inline Index find_levels_at_once(Index count, Index* levels, const Index* befores) {
  const auto thread = static_cast<Index>(threadIdx.x);
  volatile Index* const known = levels;
  __shared__ Index all;
  if (thread == 0) {
    all = 0;
  }
  bool waits = thread < count;
  int4 own{kInvalidIndex, kInvalidIndex, kInvalidIndex, kInvalidIndex};
  if (waits) {
    known[thread] = kNoLevel;
    own = reinterpret_cast<const int4*>(befores)[thread];
  }
  __syncthreads();
  const auto level_behind = [&](Index before) {
    return before == kInvalidIndex ? Index{-1} : known[before];
  };
  Index level = -1;
  while (__any_sync(~0U, waits) != 0) {
    if (waits) {
      const Index a = level_behind(own.x), b = level_behind(own.y);
      const Index c = level_behind(own.z), d = level_behind(own.w);
      const Index ab = a < b ? b : a, cd = c < d ? d : c;
      const Index last = ab < cd ? cd : ab;
      if (last != kNoLevel) {
        level = last + 1;
        known[thread] = level;
        waits = false;
      }
    }
  }
  const Index most = -least_of_warp(-level);
  if (thread % kWarp == 0) {
    atomicMax(&all, most + 1);
  }
  __syncthreads();
  return all;
}

__global__ void __launch_bounds__(kTouchListThreads)
    list_touches(DeviceState state, ToolArrays tools, StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  const Index room = input->contact_capacity < touches.contact_room ? input->contact_capacity
                                                                    : touches.contact_room;
  const Index met = list_met(touches, room);
  const Index crossed = __ldcg(&touches.searches->crossing_count);
  const Index crossings = crossed < touches.crossing_room ? crossed : touches.crossing_room;
  rank_all<kTouchListThreads>(crossings, touches.levels, [&](Index j, Index i) {
    return __ldcg(touches.crossings + j) < __ldcg(touches.crossings + i);
  });
  __syncthreads();
  for (Index i = thread; i < crossings; i += kTouchListThreads) {
    const Index at = met + __ldcg(touches.levels + i);
    if (at < room) {
      touches.order[at] = touches.vertex_count + i;
    }
  }
  __syncthreads();
  const Index all = met + crossed;
  const Index count = all < room ? all : room;
  TissueTouch touch;  // the last of this thread
  for (Index c = thread; c < count; c += kTouchListThreads) {
    const Index from = __ldcg(touches.order + c);
    touch = touches.found[from];
    touch.seen[0] = sum_of_side(state, touch, 0);
    touch.seen[1] = sum_of_side(state, touch, 1);
    touch.is_likely =
        touch.multiplier > 0 || read_plane(touch, touch.seen[0] + touch.seen[1]).gap < 0;
    touches.contacts[c] = touch;
  }
  __shared__ SharedRoom<TouchStage> shared;
  TouchStage& stage = shared.get();
  __syncthreads();
  Index levels = 0;
  if (count <= TouchStage::kContacts) {
    list_holds(touches, touch, count, stage);
    levels = find_levels_at_once(count, stage.levels, stage.room.lists.befores);
    if (thread < count) {
      touches.levels[thread] = stage.levels[thread];
    }
  } else {
    list_many_holds(touches, count);
    if (thread < kWarp) {
      levels = find_levels(count, touches.levels, [&](Index c, Index(&befores)[4]) {
        const int4 of_corners = reinterpret_cast<const int4*>(touches.befores)[c];
        befores[0] = of_corners.x;
        befores[1] = of_corners.y;
        befores[2] = of_corners.z;
        befores[3] = of_corners.w;
      });
    }
  }
  if (thread == 0) {
    *touches.level_counts = levels;
    *touches.counts = count;
    touches.searches->crossing_count = 0;
    touches.searches->most_way = 0;
    input->sums.dropped_contacts.of_bodies += all - count;
  }
}

/// As many as a large device has at once: what is near, the host does not know.
constexpr int kMeetBlocks = 512;

void find_touches(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                  Index substep, const Launch& how) {
  const TouchArrays& touches = tools.touches;
  const Index groups = touches.triangle_group_count + touches.edge_group_count;
  launch(how, "launching boxes around bodies",
         blocks_for(groups + blocks_for(touches.vertex_count, kWarp), kTouchWarps), kTouchThreads,
         fit_groups, state, tools);
  launch(how, "launching what is near bodies",
         blocks_for(touches.vertex_count + touches.edge_count, kTouchThreads), kTouchThreads,
         find_near_ones, state, tools);
  launch(how, "launching the search of bodies", share_blocks(kMeetBlocks, 8, how), kTouchThreads,
         meet_bodies, state, tools, input, substep);
  launch(how, "launching the list of contacts of bodies", 1, kTouchListThreads, list_touches, state,
         tools, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
