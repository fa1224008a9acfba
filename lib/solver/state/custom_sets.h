// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sets of custom constraints of a solver, and what a step with them needs.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <vector>

#include "pbdsurg/solver/custom_constraints.h"

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// They leave the tissue with this.
class CustomSets {
 public:
  CustomSets() = default;
  ~CustomSets() { leave_tissue(); }
  CustomSets(const CustomSets&) = delete;
  CustomSets& operator=(const CustomSets&) = delete;

  [[nodiscard]] Index count() const noexcept { return static_cast<Index>(sets_.size()); }
  [[nodiscard]] bool empty() const noexcept { return sets_.empty(); }
  [[nodiscard]] CustomConstraints& set(Index index) const { return *sets_[index]; }
  [[nodiscard]] const std::vector<std::shared_ptr<CustomConstraints>>& sets() const noexcept {
    return sets_;
  }

  /// @throws InvalidArgument  naming a set that follows a tissue already; then nothing is added
  void add(const Tissue& tissue, std::shared_ptr<CustomConstraints> set);

  /// @throws InvalidArgument  naming a set that was not added
  void remove(const CustomConstraints& set);

  /// Takes over those of another solver of the same tissue.
  void take(CustomSets& from) noexcept;

  /// Asks the sets what they are to push. Cost: O(places, and vertices that they name).
  /// @throws what they throw, and InvalidArgument, naming the set and the vertex that there is not
  void begin_step(const SolverState& state);

  /// Of that step, in the order of sets, some perhaps more than once.
  [[nodiscard]] const std::vector<Index>& places() const noexcept { return places_; }
  [[nodiscard]] bool is_named(Index place) const { return is_named_[place]; }

  /// Keeps how things move, in case that a callback fails. Cost: O(places) per copy.
  void keep(const SolverState& state);

  /// Callbacks for a copy are called no more until that is thrown: the step goes on without.
  void fail(Index copy, std::exception_ptr failure) noexcept { failures_[copy] = failure; }
  [[nodiscard]] bool has_failed(Index copy) const { return failures_[copy] != nullptr; }

  /// @throws what a callback has thrown since begin_step(), in the first copy that has such
  void rethrow();

  /// As rethrow(), and brings back what keep() has kept before.
  void end_step(SolverState& state);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void leave_tissue() noexcept;

  std::vector<std::shared_ptr<CustomConstraints>> sets_;
  std::vector<Index> places_;
  std::vector<std::uint8_t> is_named_;        // [place] by any set
  std::vector<CopyState> kept_;               // [copy]
  std::vector<std::exception_ptr> failures_;  // [copy]
};

}  // namespace pbdsurg
