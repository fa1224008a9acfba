// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A block of soft tissue, held at one side, that sags under its weight.

#include <array>
#include <vector>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::bench {

struct Cantilever {
  /// @param cells  cubes along x, y and z, of six tetrahedra each
  explicit Cantilever(const std::array<Index, 3>& cells);

  Scene scene;
  Material material;
  std::vector<Index> tip;  ///< vertices of the free end
  double length;           ///< m
  double weight;           ///< N, of all that is free
};

/// Mean displacement of the free end, m.
/// @param positions  [vertex_count] m
[[nodiscard]] Eigen::Vector3d tip_displacement(const Cantilever& bar,
                                               const std::vector<Eigen::Vector3d>& positions);

}  // namespace pbdsurg::bench
