// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/point_ids.h"

#include <algorithm>

namespace pbdsurg {

std::string PointIds::finish() {
  bool gaps = false;
  for (std::size_t i = 1; i < ids_.size() && !gaps; ++i) {
    // ids_[i - 1] + 1 could overflow
    gaps = ids_[i] <= ids_[i - 1] || ids_[i] - 1 != ids_[i - 1];
  }
  if (!gaps) {
    return {};
  }
  sorted_.reserve(ids_.size());
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    sorted_.emplace_back(ids_[i], static_cast<Index>(i));
  }
  std::sort(sorted_.begin(), sorted_.end());
  const auto twice =
      std::adjacent_find(sorted_.begin(), sorted_.end(),
                         [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != sorted_.end()) {
    return "two points have the id " + std::to_string(twice->first);
  }
  return {};
}

Index PointIds::find(std::int64_t id) const {
  if (ids_.empty()) {
    return kInvalidIndex;
  }
  if (sorted_.empty()) {
    return id < ids_.front() || id > ids_.back() ? kInvalidIndex
                                                 : static_cast<Index>(id - ids_.front());
  }
  const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), std::make_pair(id, Index{0}));
  return found == sorted_.end() || found->first != id ? kInvalidIndex : found->second;
}

}  // namespace pbdsurg
