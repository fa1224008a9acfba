// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What edits of tissue do to hinges: one lives as long as its two triangles do, and share an edge.

#include <array>
#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>

#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

struct TissueData;

/// That go with a tetrahedron: of two triangles of the surface, more or less.
inline constexpr std::size_t kHingesOfTet = 6;

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
