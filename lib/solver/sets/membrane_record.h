// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a triangle of a sheet stores, from its rest shape and material, and back.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/membrane.h"
#include "pbdsurg/tissue/scene.h"

#include "lib/solver/sets/constraint_slots.h"

namespace pbdsurg {

/// @param positions  [vertex_count] m, at rest
/// @param places     of the vertices, see SolverData
/// @param stiffness  times that of the material
[[nodiscard]] ConstraintRecord<MembraneConstraint> make_membrane(
    std::span<const Eigen::Vector3d> positions, const Triangle& triangle, const Triangle& places,
    const Body& sheet, float stiffness);

/// m, the sides from its first vertex at rest, in columns, in its plane.
[[nodiscard]] Eigen::Matrix2d rest_sides(const ConstraintRecord<MembraneConstraint>& record);

/// m^2
[[nodiscard]] double rest_area(const ConstraintRecord<MembraneConstraint>& record);

/// m, of three at rest.
[[nodiscard]] double longest_side(const ConstraintRecord<MembraneConstraint>& record);

/// Scales the rest shape of a live triangle evenly; its moduli times its thickness stay.
/// @param area  m^2, positive
void set_rest_area(ConstraintSlots<MembraneConstraint>& slots, Index triangle, float area);

/// Gives a live triangle other moduli; its rest shape stays.
/// @param stiffness  times that of the material
void set_stiffness(ConstraintSlots<MembraneConstraint>& slots, Index triangle, const Body& sheet,
                   float stiffness);

}  // namespace pbdsurg
