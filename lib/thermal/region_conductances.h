// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Electrical conductances of the tetrahedra of a region, in the shape that tissue has now.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/thermal/thermal_mesh.h"

#include "thermal/local_system.h"
#include "thermal/potential_region.h"

namespace pbdsurg {

/// Keeps conductances and a system's couplings until what they were made from has changed enough.
class RegionConductances {
 public:
  /// What they are made from.
  struct Source {
    const ThermalMesh& mesh;
    const PotentialRegion& region;
    std::span<const double> conductivities;      // [tet_count of the mesh] S/m
    std::span<const Eigen::Vector3f> positions;  // [vertex_count of the mesh] m; empty: at rest
  };

  /// Those of another region. Cost: O(region).
  void set(const Source& source, LocalSystem& system);

  /// Takes over what changed of the same region: all, if a vertex has moved far enough; else what
  /// differs at all, if any conductivity differs enough.
  /// @param most_change  of a conductivity, relative
  /// @param most_move    m
  /// @param is_due       take over what differs however little
  /// @return             whether anything was taken over, or was to be
  /// Cost: O(region) to look, O(changed) for the rest; O(region) where vertices have moved.
  bool update(const Source& source, double most_change, double most_move, bool is_due,
              LocalSystem& system);

  /// [tet_count of the region] S, of the edges in the order of kTetEdges
  [[nodiscard]] std::span<const std::array<double, 6>> values() const noexcept { return values_; }

 private:
  [[nodiscard]] bool has_moved(const Source& source, double most) const;

  std::vector<double> used_;                     // [tet_count] S/m
  std::vector<std::array<double, 6>> values_;    // [tet_count]
  std::vector<Eigen::Vector3f> used_positions_;  // [row_count] m, or empty: at rest
  // scratch
  std::vector<Index> changed_rows_;
  std::vector<char> is_changed_;  // [row_count]
};

}  // namespace pbdsurg
