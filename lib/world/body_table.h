// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The bodies of a world: ids that stay, for those of the tissue, which do not.

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/ids.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/library.h"

namespace pbdsurg {

class BodyTable final : public Follower {
 public:
  struct Entry {
    std::string name;
    TissueRecord record;
    Index in_tissue;  // kWaiting; kInvalidIndex: gone
    Index before;     // the last edit
    Index last_in_tissue;
  };

  BodyTable() = default;
  /// As another was.
  explicit BodyTable(std::vector<Entry> entries) : entries_(std::move(entries)) {}

  /// [body_count] by id
  [[nodiscard]] std::span<const Entry> entries() const noexcept { return entries_; }

  /// Adds one that the tissue has, or one that waits for an edit to bring it.
  /// @param in_tissue  kWaiting for that
  BodyId add(const std::string& name, const TissueRecord& record, Index in_tissue);
  static constexpr Index kWaiting = -2;

  /// Which body of the tissue it is.
  /// @throws InvalidArgument  naming the id that there is not, or the body that waits or has gone
  [[nodiscard]] Index in_tissue(BodyId body) const;

  /// Whether it neither waits nor has gone.
  /// @throws InvalidArgument  naming the id that there is not
  [[nodiscard]] bool is_there(BodyId body) const { return entry(body).in_tissue >= 0; }

  /// Which body of the tissue it is or was, for until a compaction those that have gone keep their
  /// numbers; kInvalidIndex if none.
  /// @throws InvalidArgument  naming the id that there is not
  [[nodiscard]] Index last_in_tissue(BodyId body) const { return entry(body).last_in_tissue; }

  /// @throws InvalidArgument  naming the id that there is not
  [[nodiscard]] const TissueRecord& record(BodyId body) const;
  [[nodiscard]] const std::string& name(BodyId body) const;

  /// The last of that name.
  /// @throws InvalidArgument  naming the bodies that there are
  [[nodiscard]] BodyId find(const std::string& name) const;

  /// Gives up those that wait: the edit that was to bring them was refused.
  void stop_waiting() noexcept;

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  [[nodiscard]] const Entry& entry(BodyId body) const;

  std::vector<Entry> entries_;
};

}  // namespace pbdsurg
