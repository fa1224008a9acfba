// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who follows a tissue.

#include <cstdint>
#include <vector>

#include "pbdsurg/tissue/follower.h"

namespace pbdsurg {

/// Ascending by rank, then in the order of registration.
class FollowerList {
 public:
  struct Entry {
    Follower* follower;
    FollowerRank rank;
    std::uint64_t version;  ///< of the tissue when it was registered
  };

  void add(const Entry& entry);
  void remove(const Follower* follower) noexcept;
  void exchange(const Follower* follower, Follower* other) noexcept;

  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }

 private:
  std::vector<Entry> entries_;
};

}  // namespace pbdsurg
