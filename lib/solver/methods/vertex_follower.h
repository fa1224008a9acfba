// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How the rows of vertices follow edits.

#include <optional>

#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg {

class SolverData;

/// Keeps the rows of vertices up to date, in proportion to the edit; but where it brings many
/// vertices, or the first damping, they are laid out anew, in O(vertex_count log vertex_count).
class VertexFollower final : public Follower {
 public:
  explicit VertexFollower(SolverData& data) : data_(data) {}

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return before_growth_ ? before_growth_->memory_bytes() : 0;
  }

  void validate(const Tissue& tissue, const TopologyEdit& edit) const override;
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

 private:
  void set_limit(const Tissue& tissue, Index edge);
  void remove(const TissueChange& change);
  void set_free(Index place);
  bool grow(const Tissue& tissue, const TissueChange& change);  // whether it has changed anything
  void regrow(const Tissue& tissue, const TissueChange& change);
  void refresh();

  SolverData& data_;
  bool has_grown_ = false;                     // in the last edit
  std::optional<VertexBlocks> before_growth_;  // of it, where rows were laid out anew
};

}  // namespace pbdsurg
