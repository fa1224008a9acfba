// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which topology a participant of edits is at.

#include <cstdint>
#include <utility>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/export.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

struct Renumbering;

/// The version of the topology that a participant follows: after an edit that it missed, its ids
/// would mean something else.
class PBDSURG_API FollowedVersion {
 public:
  /// Of a solver that was never edited.
  FollowedVersion() = default;
  explicit FollowedVersion(const Solver& solver) : now_(solver.topology_version()) {}
  FollowedVersion(const FollowedVersion&) = default;
  FollowedVersion& operator=(const FollowedVersion&) = default;
  /// What is moved from follows nothing any more: check() and renumber() then say so.
  FollowedVersion(FollowedVersion&& other) noexcept
      : now_(std::exchange(other.now_, kMovedFrom)),
        before_(std::exchange(other.before_, kMovedFrom)) {}
  FollowedVersion& operator=(FollowedVersion&& other) noexcept {
    now_ = std::exchange(other.now_, kMovedFrom);
    before_ = std::exchange(other.before_, kMovedFrom);
    return *this;
  }

  /// For what a participant does without a solver.
  /// @throws InvalidArgument  if this, and so the participant, was moved from
  void check_not_moved_from(const char* who) const;

  /// For the participant's validate(), and for all else that it does with the solver.
  /// @param who  names the participant in the error, for example "a heat field"
  /// @throws InvalidArgument  if the solver's topology is another, or this was moved from
  void check(const Solver& solver, const char* who) const;

  /// For the participant's apply() and undo().
  void apply(const EditResult& result) noexcept {
    before_ = now_;
    now_ = result.topology_version;
  }
  void undo() noexcept { now_ = before_; }

  /// For participants that go along with a compaction. Cost: O(maps).
  /// @throws InvalidArgument  if the compaction was of another topology than the one followed, or
  ///                          the solver's is not the one that it made, or maps of ids lead beyond
  ///                          what that has; then nothing has changed
  void renumber(const Solver& solver, const Renumbering& ids, const char* who);

 private:
  static constexpr std::uint64_t kMovedFrom = ~std::uint64_t{0};  // no solver gets there

  std::uint64_t now_ = 0;
  std::uint64_t before_ = 0;  // the last edit
};

}  // namespace pbdsurg
