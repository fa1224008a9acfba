// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Whether tissue still hangs together where elements have gone.

#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"

#include "lib/heat/potential_region.h"

namespace pbdsurg {

class RegionJoints {
 public:
  /// Whether what elements that conduct no more joined is still joined within some rings of them,
  /// without crossing ground: then a search would meet all else of the region as before. Also no
  /// where ground was touched, or where the way round is longer.
  /// @param search          the last of which found `region`
  /// @param gone            places of those elements among those of the region
  /// @param conductivities  S/m
  /// Cost: O(gone), for the elements within these rings.
  bool hold_without(std::span<const Index> gone, const ThermalMesh& mesh,
                    const PotentialRegion& region, const RegionSearch& search,
                    const ElementSpan& conductivities);

 private:
  void meet(Index row);
  [[nodiscard]] Index root(Index row);
  [[nodiscard]] bool are_joined(const Tet& rows, Index& common);
  bool search_rings(std::span<const Index> gone, const ThermalMesh& mesh,
                    const PotentialRegion& region, const RegionSearch& search,
                    const ElementSpan& conductivities);

  std::vector<Index> parents_;  // [row_count] of a forest, kInvalidIndex but within a call
  std::vector<Index> met_;      // rows
};

}  // namespace pbdsurg
