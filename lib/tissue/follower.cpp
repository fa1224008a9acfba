// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/follower.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/tissue/follower_list.h"

namespace pbdsurg {

void FollowerList::add(const Entry& entry) {
  if (visits_ > 0) {
    throw InvalidArgument("a follower cannot come within an edit");
  }
  entries_.insert(std::ranges::upper_bound(entries_, entry.rank, {}, &Entry::rank), entry);
}

void FollowerList::remove(const Follower* follower) noexcept {
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->follower == follower) {
      if (visits_ > 0) {
        entry->follower = nullptr;
      } else {
        entries_.erase(entry);
      }
      return;
    }
  }
}

void FollowerList::exchange(const Follower* follower, Follower* other) noexcept {
  for (Entry& entry : entries_) {
    if (entry.follower == follower) {
      entry.follower = other;
    }
  }
}

Follower::Follower(const Follower& /*other*/) {}

Follower::Follower(Follower&& other) noexcept : list_(std::move(other.list_)) {
  if (const auto list = list_.lock()) {
    list->exchange(&other, this);
  }
}

Follower& Follower::operator=(const Follower& other) {
  if (this != &other) {
    leave_tissue();
  }
  return *this;
}

Follower& Follower::operator=(Follower&& other) noexcept {
  if (this != &other) {
    leave_tissue();
    list_ = std::move(other.list_);
    if (const auto list = list_.lock()) {
      list->exchange(&other, this);
    }
  }
  return *this;
}

Follower::~Follower() {
  leave_tissue();
}

void Follower::leave_tissue() noexcept {
  if (const auto list = list_.lock()) {
    list->remove(this);
  }
  list_.reset();
}

}  // namespace pbdsurg
