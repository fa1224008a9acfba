// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hinges and their two triangles, and what edits of tissue do to hinges: one lives as long as
/// these do, and share an edge.

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory_resource>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/tissue/topology_edit.h"

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// That go with a tetrahedron: of two triangles of the surface, more or less.
inline constexpr std::size_t kHingesOfTet = 6;

/// @param side  0 or 1
[[nodiscard]] inline Triangle triangle_of_hinge(const std::array<Index, 4>& hinge,
                                                std::size_t side) {
  return {hinge[0], hinge[1], hinge[2 + side]};
}

[[nodiscard]] inline bool has_all(std::span<const Index> corners, const Triangle& triangle) {
  return std::ranges::all_of(
      triangle, [&](Index v) { return std::ranges::find(corners, v) != corners.end(); });
}

/// Calls visit(hinge) for each that has a triangle of a tetrahedron, or is of a sheet's triangle;
/// some twice.
/// @param corners  [4] or [3]
template <class Visit>
void for_each_hinge_of(const TissueData& data, std::span<const Index> corners, Visit visit) {
  for (std::size_t i = 0; i < 2; ++i) {  // a triangle has one of any two corners
    for (const Index hinge : data.hinges_at(corners[i])) {
      const std::array<Index, 4>& v = data.hinges[hinge].vertices;
      if (has_all(corners, triangle_of_hinge(v, 0)) || has_all(corners, triangle_of_hinge(v, 1))) {
        visit(hinge);
      }
    }
  }
}

/// The triangles of a live hinge, if it is of a sheet.
[[nodiscard]] std::optional<std::array<Index, 2>> sheet_triangles(const Tissue& tissue,
                                                                  Index hinge);

/// How many times as stiff as its rigidity says a live hinge is: in a sheet, as its two triangles
/// in the mean; on a solid 1.
[[nodiscard]] double hinge_stiffness(const Tissue& tissue, Index hinge);

/// [hinge_count] the same of a scene.
[[nodiscard]] std::vector<double> hinge_stiffnesses(const Scene& scene);

/// Removes the hinges of a live tetrahedron's triangles, or of a sheet's triangle.
/// @param corners  [4] or [3]
void remove_hinges(TissueData& data, std::span<const Index> corners);

/// Hinges of tetrahedra that an edit parts or splits, and of triangles of sheets that it parts.
/// Their triangles go to the tetrahedra that come of these, and may have copies of their vertices
/// then.
class PartedHinges {
 public:
  /// Before corners move.
  PartedHinges(const TissueData& data, const TopologyEdit& edit);

  /// Once tetrahedra are what they are to be. Hinges whose triangles have no edge in common any
  /// more are removed, others follow. Cost: O(n log n) in hinges and tetrahedra that were split.
  void settle(TissueData& data, const TopologyEdit& edit) const;

 private:
  struct Parted {
    Index hinge;
    std::array<Index, 2> owners;  // of its triangles, before: tetrahedra, or triangles of a sheet
    bool is_of_sheet;

    bool operator==(const Parted&) const = default;
  };

  std::pmr::vector<Parted> hinges_;  // ascending
};

}  // namespace pbdsurg
