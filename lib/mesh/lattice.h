// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A body-centred cubic lattice that stores values only in blocks that touch a shape.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/implicit_shape.h"

namespace pbdsurg {

/// A lattice point in half cells: corners have three even coordinates, centres three odd ones.
using Site = Eigen::Vector3i;

/// The 14 neighbours of a lattice point: 6 along the axes (long edges, one cell) and 8 along the
/// diagonals (short edges, sqrt(3)/2 cells). Directions 2 i and 2 i + 1 are opposite.
inline constexpr int kDirectionCount = 14;
inline constexpr int kLongDirectionCount = 6;
extern const std::array<Site, kDirectionCount> kDirections;

/// Values of a shape at lattice points. Blocks of 6 x 6 x 6 cells far from the surface get a single
/// value; those outside are not stored at all.
class Lattice {
 public:
  static constexpr int kBlockCells = 6;
  static constexpr int kBlockSites = 2 * kBlockCells * kBlockCells * kBlockCells;

  /// See stuff() for parameters and errors.
  Lattice(const ImplicitShape& shape, double spacing, const Eigen::Vector3d& shift,
          std::int64_t max_cells);

  /// Number of stored sites: addresses run from 0 to here, block after block.
  [[nodiscard]] Index site_count() const { return static_cast<Index>(values_.size()); }
  [[nodiscard]] Site site_at(Index address) const;

  /// Where a site is stored; kInvalidIndex outside the shape's blocks and outside the lattice.
  [[nodiscard]] Index address(const Site& site) const;

  [[nodiscard]] double value(Index address) const { return values_[address]; }
  [[nodiscard]] Eigen::Vector3d position(const Site& site) const {
    return origin_ + 0.5 * spacing_ * site.cast<double>();
  }

 private:
  double spacing_;
  Eigen::Vector3d origin_;
  Eigen::Vector3i block_count_;
  std::vector<Index> slot_of_block_;
  std::vector<Index> block_of_slot_;
  std::vector<double> values_;  // [slot count * kBlockSites]
};

}  // namespace pbdsurg
