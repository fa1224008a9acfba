// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which triangles of a surface are skin, and which a cut or a burn has bared.

#include <array>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/tissue.h"

namespace cholecystectomy {

/// Knows of each vertex between which of the first ones it came to be: edits put new vertices on
/// edges, or where others are. So a triangle is a piece of skin if the three corners of one
/// triangle of the skin at first are all that its corners lie between.
class SkinRecord final : public pbdsurg::Follower {
 public:
  /// @param tissue  followed from here on
  /// @param skin    scene vertices of all its triangles
  SkinRecord(const pbdsurg::Tissue& tissue, std::vector<pbdsurg::Triangle> skin);

  /// @param triangle  scene vertices, of the surface
  [[nodiscard]] bool has(const pbdsurg::Triangle& triangle) const;

  void follow(const pbdsurg::Tissue& tissue, const pbdsurg::TissueChange& change) noexcept override;
  void undo(const pbdsurg::Tissue& tissue, const pbdsurg::TissueChange& change) noexcept override;
  void renumber(const pbdsurg::Tissue& tissue, const pbdsurg::Renumbering& ids) noexcept override;

 private:
  /// First vertices by their ids at first, ascending, then kInvalidIndex; none where there would be
  /// more than three: that is below the skin.
  using Origin = std::array<pbdsurg::Index, 3>;
  static constexpr Origin kNone{pbdsurg::kInvalidIndex, pbdsurg::kInvalidIndex,
                                pbdsurg::kInvalidIndex};

  static Origin both(const Origin& a, const Origin& b);

  std::vector<Origin> skin_;     // of its triangles, sorted
  std::vector<Origin> origins_;  // [vertex_count]
};

}  // namespace cholecystectomy
