// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colours for a few among many that have theirs.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// A walk (color_walk.h) that looks at no more than it reaches: its cost does not depend on how
/// many there are.
class LocalWalk {
 public:
  /// Those that need another colour than one, valid until the next call. The same each time until
  /// forget_conflicts().
  using ConflictsOf = std::function<std::span<const Index>(Index)>;
  struct Change {
    Index constraint, color;
  };

  /// Makes room for so many.
  void reserve(std::size_t count) { index_of_.reserve(count); }

  /// Gives those without a colour one of some, and others another of these where it has to.
  /// @param uncolored  may have a colour; all others have one of `colors`, or are in no conflict
  /// @param color_of   stays as it is
  /// @param effort     how many conflicts the walk may look at
  /// @return whether all could have one; if so, changes() says which
  PBDSURG_API bool run(std::span<const Index> uncolored, std::span<const Index> colors,
                       const std::vector<Index>& color_of, const ConflictsOf& conflicts_of,
                       std::int64_t effort);

  /// Of the last run: whose colours are to be others than in color_of.
  [[nodiscard]] std::span<const Change> changes() const noexcept { return changes_; }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return sizeof(Index) * (index_of_.size() + reached_.size() + conflicts_.size()) +
           sizeof(List) * lists_.size() + sizeof(Change) * changes_.size();
  }

  /// Cost: that of the runs before.
  PBDSURG_API void forget_conflicts() noexcept;

 private:
  struct List {
    std::size_t first = 0, count = 0;
    bool is_known = false;
  };

  [[nodiscard]] Index index_of(Index constraint);

  std::vector<Index> index_of_;  // [constraint] among those that were reached, or kInvalidIndex
  std::vector<Index> reached_;
  std::vector<List> lists_;       // [reached] their conflicts, once looked at
  std::vector<Index> conflicts_;  // of these, among those that were reached
  std::vector<Change> changes_;
};

}  // namespace pbdsurg
