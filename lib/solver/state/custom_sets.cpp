// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/custom_sets.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

void CustomSets::add(const Tissue& tissue, std::shared_ptr<CustomConstraints> set) {
  if (set->is_following()) {
    const bool is_here = std::ranges::find(sets_, set) != sets_.end();
    throw InvalidArgument("constraint set '" + set->name() + "' " +
                          (is_here ? "was added to this solver already"
                                   : "follows a tissue already; a solver registers what is added "
                                     "to it, and a set is of one solver"));
  }
  sets_.reserve(sets_.size() + 1);
  tissue.add_follower(*set, FollowerRank::user);
  sets_.push_back(std::move(set));
}

void CustomSets::remove(const CustomConstraints& set) {
  const auto found = std::ranges::find(
      sets_, &set, [](const std::shared_ptr<CustomConstraints>& each) { return each.get(); });
  if (found == sets_.end()) {
    throw InvalidArgument("constraint set '" + set.name() + "' was not added to this solver");
  }
  (*found)->leave_tissue();
  sets_.erase(found);
}

void CustomSets::take(CustomSets& from) noexcept {
  sets_ = std::exchange(from.sets_, {});
}

void CustomSets::leave_tissue() noexcept {
  for (const auto& set : sets_) {
    set->leave_tissue();
  }
}

void CustomSets::begin_step(const SolverState& state) {
  places_.clear();
  if (empty()) {
    return;
  }
  is_named_.assign(state.particles.size(), 0);
  failures_.assign(static_cast<std::size_t>(state.copy_count()), nullptr);
  for (const auto& set : sets_) {
    set->begin_step(state.copy_count());
    for (const Index v : set->vertices()) {
      if (v < 0 || static_cast<std::size_t>(v) >= state.place_of_vertex.size()) {
        throw InvalidArgument("constraint set '" + set->name() + "' names vertex " +
                              std::to_string(v) + "; ids must be in [0, " +
                              std::to_string(state.place_of_vertex.size()) + ")");
      }
      places_.push_back(state.place_of_vertex[v]);
      is_named_[places_.back()] = 1;
    }
  }
}

void CustomSets::keep(const SolverState& state) {
  kept_.resize(static_cast<std::size_t>(state.copy_count()));
  for (Index i = 0; i < state.copy_count(); ++i) {
    kept_[i] = state.copy(i);
  }
}

void CustomSets::rethrow() {
  const std::vector<std::exception_ptr> failures = std::exchange(failures_, {});
  for (const std::exception_ptr& failure : failures) {
    if (failure != nullptr) {
      std::rethrow_exception(failure);
    }
  }
}

void CustomSets::end_step(SolverState& state) {
  if (std::ranges::all_of(failures_, [](const auto& failure) { return failure == nullptr; })) {
    return;
  }
  for (Index i = 0; i < state.copy_count(); ++i) {
    state.copy(i) = kept_[i];
  }
  rethrow();
}

std::size_t CustomSets::memory_bytes() const noexcept {
  std::size_t bytes = places_.capacity() * sizeof(Index) + is_named_.capacity();
  for (const CopyState& copy : kept_) {
    bytes += copy.memory_bytes();
  }
  return bytes;
}

}  // namespace pbdsurg
