// SPDX-License-Identifier: Apache-2.0
#include "lib/device/record_table.h"

namespace pbdsurg::cuda {

RecordTable::Location& RecordTable::location(Holder holder, Index id) {
  std::vector<Location>& all = locations_[static_cast<std::size_t>(holder)];
  if (id >= static_cast<Index>(all.size())) {
    all.resize(static_cast<std::size_t>(id) + 1);
  }
  return all[id];
}

Index RecordTable::add_pool(DeviceArray array) {
  pools_.push_back({array, {}});
  return static_cast<Index>(pools_.size()) - 1;
}

void RecordTable::hold(Index pool, Holder holder, Index id, Index record) {
  location(holder, id) = {pool, record};
  holders_[static_cast<std::size_t>(pools_[pool].array)][record] = id;
}

void RecordTable::add(Index pool, Holder holder, Index id, Index record) {
  std::vector<Index>& holders = holders_[static_cast<std::size_t>(pools_[pool].array)];
  holders.resize(static_cast<std::size_t>(record) + 1, kInvalidIndex);
  hold(pool, holder, id, record);
}

void RecordTable::add_serial(Holder holder, Index id) {
  location(holder, id) = {kSerialPool, kInvalidIndex};
}

void RecordTable::add_free(Index pool, Index first, Index count) {
  auto& [array, free] = pools_[pool];
  for (Index i = count; i-- > 0;) {
    free.push_back(first + i);
  }
  holders_[static_cast<std::size_t>(array)].resize(static_cast<std::size_t>(first + count),
                                                   kInvalidIndex);
}

bool RecordTable::leave(Holder holder, Index id, Index wanted) {
  Location& now = location(holder, id);
  if (now.pool == kSerialPool || wanted == kSerialPool || wanted == kNoPool) {
    return false;
  }
  if (now.pool == kNoPool) {
    return true;
  }
  Pool& pool = pools_[now.pool];
  touched_.push_back({pool.array, now.record});
  if (wanted != now.pool && wanted != kRemoved) {
    pool.free.push_back(now.record);
    holders_[static_cast<std::size_t>(pool.array)][now.record] = kInvalidIndex;
    now = {};
  }
  return true;
}

bool RecordTable::join(Holder holder, Index id, Index wanted) {
  if (wanted < 0 || location(holder, id).pool == wanted) {
    return true;
  }
  auto& [array, free] = pools_[wanted];
  if (free.empty()) {
    return false;
  }
  const Index record = free.back();
  free.pop_back();
  hold(wanted, holder, id, record);
  touched_.push_back({array, record});
  return true;
}

}  // namespace pbdsurg::cuda
