// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Electrical conductances of the elements of a region, in the shape that tissue has now.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"

#include "lib/heat/device_system.h"
#include "lib/heat/local_system.h"
#include "lib/heat/potential_region.h"

namespace pbdsurg {

/// Keeps conductances, and who solves with them, until what they were made from has changed enough.
class RegionConductances {
 public:
  /// What they are made from.
  struct Source {
    const ThermalMesh& mesh;
    const PotentialRegion& region;
    std::span<const double> conductivities;      // [element_count of the region] S/m, 0: gone
    std::span<const Eigen::Vector3f> positions;  // [vertex_count of the mesh] m; empty: at rest
  };

  /// Who solves with them, with rows of this region.
  struct Takers {
    LocalSystem& system;
    DeviceSystem* device;  // in place of the system; or null
  };

  /// Those of another region. Cost: O(region).
  /// @throws Error  as the device
  void set(const Source& source, const Takers& takers);

  /// Takes over what changed of the same region: all, if a vertex has moved far enough; else what
  /// differs at all, if any conductivity differs enough, goes or comes back.
  /// @param most_change  of a conductivity, relative
  /// @param most_move    m
  /// @param is_due       take over what differs however little
  /// @return             whether anything was taken over, or was to be
  /// @throws Error       as the device
  /// Cost: O(region) to look, O(changed) for the rest; O(region) where vertices have moved.
  bool update(const Source& source, double most_change, double most_move, bool is_due,
              const Takers& takers);

  /// [element_count of the region] S/m, zero for what has gone
  [[nodiscard]] std::span<const double> used() const noexcept { return used_; }

  /// [element_count of the region] S, of the edges in the order of kTetEdges; for a device m, as
  /// used() goes up with each solution
  [[nodiscard]] std::span<const std::array<double, 6>> values() const noexcept { return values_; }

 private:
  [[nodiscard]] bool has_moved(const Source& source, double most) const;
  void use(const Source& source, std::size_t i, bool is_on_device);

  std::vector<double> used_;                     // [element_count] S/m
  std::vector<std::array<double, 6>> values_;    // [element_count]
  std::vector<Eigen::Vector3f> used_positions_;  // [row_count] m, or empty: at rest
  // scratch
  std::vector<Index> changed_rows_;
  std::vector<char> is_changed_;  // [row_count]
};

}  // namespace pbdsurg
