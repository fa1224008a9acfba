// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Index and element types shared by every module. All quantities are in SI units.

#include <array>
#include <cstdint>

namespace pbdsurg {

/// Position of an element in an array: a vertex, a tetrahedron, a constraint.
using Index = std::int32_t;

/// No element.
inline constexpr Index kInvalidIndex = -1;

/// Vertex ids of an edge, smaller id first.
using Edge = std::array<Index, 2>;

/// Vertex ids of a triangle, counter-clockwise when seen from outside.
using Triangle = std::array<Index, 3>;

/// Vertex ids of a tetrahedron of positive volume: seen from the fourth vertex, the first three
/// run clockwise, so that (x1 - x0) x (x2 - x0) points towards x3.
using Tet = std::array<Index, 4>;

}  // namespace pbdsurg
