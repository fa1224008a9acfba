// SPDX-License-Identifier: Apache-2.0
#include "lib/device/cluster_slots.h"

#include <algorithm>

namespace pbdsurg::cuda {

void ClusterSlots::set_place_count(Index place_count) {
  const auto count = static_cast<std::size_t>(place_count);
  slots_.resize(count * blocks_.size(), kInvalidIndex);
  homes_.resize(count, kInvalidIndex);
}

void ClusterSlots::acquire(Index block, Index place) {
  Index& slot = slots_[at(block, place)];
  if (slot != kInvalidIndex) {
    return;
  }
  auto& [places, free, home_count] = blocks_[block];
  if (free.empty()) {
    slot = static_cast<Index>(places.size());
    places.push_back(place);
  } else {
    slot = free.back();
    free.pop_back();
    places[slot] = place;
  }
  changed.emplace_back(block, slot);
}

void ClusterSlots::release(Index block, Index place) {
  Index& slot = slots_[at(block, place)];
  blocks_[block].places[slot] = kInvalidIndex;
  blocks_[block].free.push_back(slot);
  changed.emplace_back(block, slot);
  slot = kInvalidIndex;
}

void ClusterSlots::settle(Index block, Index place) {
  swap(block, slots_[at(block, place)], blocks_[block].home_count++);
  homes_[place] = block;
}

void ClusterSlots::unsettle(Index place) {
  const Index block = homes_[place];
  swap(block, slots_[at(block, place)], --blocks_[block].home_count);
  homes_[place] = kInvalidIndex;
}

void ClusterSlots::swap(Index block, Index a, Index b) {
  auto& [places, free, home_count] = blocks_[block];
  changed.emplace_back(block, a);
  if (a == b) {
    return;
  }
  changed.emplace_back(block, b);
  std::swap(places[a], places[b]);
  for (const auto& [now, before] : {std::pair(a, b), std::pair(b, a)}) {
    if (places[now] == kInvalidIndex) {
      *std::ranges::find(free, before) = now;
    } else {
      slots_[at(block, places[now])] = now;
      moved.push_back(places[now]);
    }
  }
}

}  // namespace pbdsurg::cuda
