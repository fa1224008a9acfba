// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// For what goes along with a compaction: values and lists of ids, from old ids to new ones.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// The new id; kInvalidIndex for that itself, and for one that the map does not have.
inline Index new_id(Index id, const std::vector<Index>& ids) {
  return id >= 0 && static_cast<std::size_t>(id) < ids.size() ? ids[id] : kInvalidIndex;
}

/// What is at each new id. @param ids  old to new  @param value_of  Value(Index old_id)
template <class Value, class ValueOf>
std::vector<Value> moved(const std::vector<Index>& ids, std::size_t count, ValueOf value_of) {
  std::vector<Value> values(count);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] != kInvalidIndex) {
      values[ids[i]] = value_of(static_cast<Index>(i));
    }
  }
  return values;
}

/// @param values  [ids.size()] by old ids
template <class Value>
void renumber_values(std::vector<Value>& values, const std::vector<Index>& ids, std::size_t count) {
  values = moved<Value>(ids, count, [&](Index i) { return values[i]; });
}

/// Those of a list that live, in their order.
inline void renumber_list(std::vector<Index>& list, const std::vector<Index>& ids) {
  std::ranges::transform(list, list.begin(), [&](Index id) { return new_id(id, ids); });
  std::erase(list, kInvalidIndex);
}

}  // namespace pbdsurg
