// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a Neo-Hookean tetrahedron stores, from its rest shape and material, and back.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/material.h"

#include "lib/solver/sets/constraint_slots.h"

namespace pbdsurg {

/// @param positions  [vertex_count] m, at rest
/// @param places     of the vertices, see SolverData
/// @param stiffness  times that of the material
ConstraintRecord<NeoHookeanConstraint> make_neo_hookean(std::span<const Eigen::Vector3d> positions,
                                                        const Tet& tet, const Tet& places,
                                                        const Material& material, float stiffness);

/// 1/m, of the sides from its first vertex at rest.
[[nodiscard]] Eigen::Matrix3d inverse_shape(
    const ConstraintRecord<NeoHookeanConstraint>& record) noexcept;

/// m, these sides, in columns.
[[nodiscard]] Eigen::Matrix3d rest_sides(const ConstraintRecord<NeoHookeanConstraint>& record);

/// Of a tetrahedron with the same material inside of another.
/// @param sides  its sides from its first vertex, in columns, in terms of those of the other
/// @param places  of its vertices
[[nodiscard]] ConstraintRecord<NeoHookeanConstraint> make_part(
    const ConstraintRecord<NeoHookeanConstraint>& whole, const Eigen::Matrix3d& sides,
    const Tet& places);

/// m^3
float rest_volume(const ConstraintRecord<NeoHookeanConstraint>& record) noexcept;

/// Gives a live tetrahedron other moduli; its rest shape stays.
/// @param stiffness  times that of the material
void set_stiffness(ConstraintSlots<NeoHookeanConstraint>& slots, Index tet,
                   const Material& material, float stiffness);

/// Scales the rest shape of a live tetrahedron evenly; its moduli stay.
/// @param volume  m^3, positive
void set_rest_volume(ConstraintSlots<NeoHookeanConstraint>& slots, Index tet, float volume);

}  // namespace pbdsurg
