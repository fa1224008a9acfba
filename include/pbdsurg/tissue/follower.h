// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What holds something by the ids of living tissue, and follows its edits.

#include <cstdint>
#include <memory>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

struct Renumbering;
class Tissue;
struct TissueChange;
struct TopologyEdit;

class FollowerList;

/// The order in which followers follow: each may read those of lower rank. Followers of one rank
/// follow in the order in which they were registered.
enum class FollowerRank : std::uint8_t { solver, heat, view, surgery, user };

/// A heat field, a surface to draw, the constraints of a solver, collision data of a user's own.
/// Tissue::add_follower() registers one, at any time. From then on it takes part in each edit of
/// that tissue, after the tissue and after followers of lower rank, until it is destroyed. The
/// registration moves with it; a copy has none. One may leave within an edit; none may come. Where
/// memory runs out in a noexcept function, the program ends.
class PBDSURG_API Follower {
 public:
  Follower() = default;
  Follower(const Follower& other);                 ///< follows nothing
  Follower(Follower&& other) noexcept;             ///< takes over the registration
  Follower& operator=(const Follower& other);      ///< follows nothing from here on
  Follower& operator=(Follower&& other) noexcept;  ///< takes over the registration
  virtual ~Follower();

  /// Refuses an edit by throwing. Changes nothing. The tissue is as before the edit, and has
  /// checked its own rules.
  virtual void validate(const Tissue& /*tissue*/, const TopologyEdit& /*edit*/) const {}

  /// Refuses an undo by throwing. Changes nothing.
  virtual void validate_undo(const Tissue& /*tissue*/, const TissueChange& /*change*/) const {}

  /// Follows an edit that all have accepted.
  /// @param tissue  as after the edit
  virtual void follow(const Tissue& tissue, const TissueChange& change) noexcept = 0;

  /// Goes back to where it was before the edit that it followed last, bit for bit.
  /// @param tissue  as before the edit
  virtual void undo(const Tissue& tissue, const TissueChange& change) noexcept = 0;

  /// Goes along with a compaction: all ids are others, and no edit before it can be undone.
  /// @param tissue  with the new ids
  virtual void renumber(const Tissue& tissue, const Renumbering& ids) noexcept = 0;

  /// From here on it follows nothing.
  void leave_tissue() noexcept;

  /// Whether it follows a tissue.
  [[nodiscard]] bool is_following() const noexcept { return !list_.expired(); }

 private:
  friend class Tissue;

  std::weak_ptr<FollowerList> list_;  // that it is in
};

}  // namespace pbdsurg
