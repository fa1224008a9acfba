// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How thick a shape is, for lattices that have to resolve it.

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "pbdsurg/mesh/implicit_shape.h"

#include "lib/mesh/stuffing.h"

namespace pbdsurg {

/// A ball of radius sqrt(5)/4 cells always holds a lattice point, so a wall of this many cells has
/// no holes.
inline constexpr double kThinnestWall = 1 / 0.89;

/// Depths below the surface are measured from this on, to this.
inline constexpr double kLeastDepth = 0.02;  // in cells

/// How thick a shape is, looking inwards from its surface.
struct Thickness {
  double thinnest = 0;    ///< m, but for a twentieth of the surface: feathered edges do not count
  double median = 0;      ///< m
  double area = 0;        ///< m^2, of the surface: of both sides of a sheet
  double least_area = 0;  ///< m^2, less two standard errors
  double volume = 0;      ///< m^3, of the inside
  Eigen::AlignedBox3d box{};  ///< of the surface, which may be far smaller than the shape's bounds
};

/// Looks inwards from points of the surface near the lattice's; none if no value is near zero.
[[nodiscard]] std::optional<Thickness> measure_thickness(const ImplicitShape& shape, double spacing,
                                                         std::int64_t max_cells);

/// The share of a mesh's boundary vertices below which the shape is thinner than kThinnestWall:
/// walks inwards from the boundary until the shape ends.
[[nodiscard]] double thin_share(const ImplicitShape& shape, double spacing,
                                const StuffedMesh& mesh);

}  // namespace pbdsurg
