// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who follows a tissue.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/tissue/follower.h"

namespace pbdsurg {

/// Ascending by rank, then in the order of registration. Who leaves while all are visited is not
/// visited any more.
class FollowerList {
 public:
  struct Entry {
    Follower* follower;
    FollowerRank rank;
    std::uint64_t version;  ///< of the tissue when it was registered
  };

  /// @throws InvalidArgument  while all are visited
  void add(const Entry& entry);
  void remove(const Follower* follower) noexcept;
  void exchange(const Follower* follower, Follower* other) noexcept;

  /// Calls visit(entry) for each, in their order.
  template <class Visit>
  void for_each(Visit visit) {
    const Visiting visiting(*this);
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (entries_[i].follower != nullptr) {
        visit(entries_[i]);
      }
    }
  }

 private:
  // While one lives, entries stay where they are.
  struct Visiting {
    explicit Visiting(FollowerList& visited) : list(visited) { ++list.visits_; }
    ~Visiting() {
      if (--list.visits_ == 0) {
        std::erase_if(list.entries_, [](const Entry& entry) { return entry.follower == nullptr; });
      }
    }
    Visiting(const Visiting&) = delete;
    Visiting& operator=(const Visiting&) = delete;

    FollowerList& list;
  };

  std::vector<Entry> entries_;  // null: left while all are visited
  int visits_ = 0;
};

}  // namespace pbdsurg
