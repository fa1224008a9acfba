// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All edits of a tissue since a moment, to do them again elsewhere.

#include <memory>
#include <utility>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

class PBDSURG_API EditJournal final : public Follower {
 public:
  /// Those that were not undone, in their order. States of a world share them.
  using Edits = std::vector<std::shared_ptr<const TopologyEdit>>;

  EditJournal() = default;
  /// Goes on after these.
  explicit EditJournal(Edits edits) : edits_(std::move(edits)) {}

  [[nodiscard]] const Edits& edits() const noexcept { return edits_; }
  /// Whether a compaction has given all ids another meaning.
  [[nodiscard]] bool was_renumbered() const noexcept { return was_renumbered_; }

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  Edits edits_;
  bool was_renumbered_ = false;  // from then on it keeps nothing
};

}  // namespace pbdsurg
