// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Names that a file gives to its points, with gaps and in any order.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Maps the ids of a file to positions 0, 1, 2 ... in the order in which they were added.
class PointIds {
 public:
  void reserve(std::size_t count) { ids_.reserve(count); }
  void add(std::int64_t id) { ids_.push_back(id); }

  /// To be called once after the last add().
  /// @return  why the ids are wrong, empty when all differ
  [[nodiscard]] std::string finish();

  /// Position of an id, kInvalidIndex if no point has it. O(1) without gaps, else O(log n).
  [[nodiscard]] Index find(std::int64_t id) const;

  [[nodiscard]] std::size_t count() const { return ids_.size(); }

 private:
  std::vector<std::int64_t> ids_;
  std::vector<std::pair<std::int64_t, Index>> sorted_;  // empty when the ids have no gaps
};

}  // namespace pbdsurg
