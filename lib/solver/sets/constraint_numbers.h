// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What constraints have for numbers, apart from where their vertices are.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/fibre.h"
#include "pbdsurg/constraints/membrane.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/stiff_link.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

template <class Constraint>
using Numbers = std::array<float, Constraint::kParameterCount>;

/// Of an edge, where it has such constraints.
struct EdgeNumbers {
  std::optional<Numbers<DistanceConstraint>> distance;
  std::optional<Numbers<StrainLimitConstraint>> limit;
};

/// Of a tetrahedron.
struct TetNumbers {
  std::optional<Numbers<VolumeConstraint>> volume;
  std::optional<Numbers<NeoHookeanConstraint>> neo_hookean;
  std::optional<Numbers<FibreConstraint>> fibre;
};

/// Of a triangle of a sheet, where it is alive.
using TriangleNumbers = std::optional<Numbers<MembraneConstraint>>;

/// Of a hinge, where it is alive.
using HingeNumbers = std::optional<Numbers<BendingConstraint>>;

/// Of a link, where it is alive and stiff.
using StiffLinkNumbers = std::optional<Numbers<StiffLinkConstraint>>;

/// Of some tissue.
struct ConstraintNumbers {
  std::vector<EdgeNumbers> edges;             ///< [edge_count]
  std::vector<TetNumbers> tets;               ///< [tet_count]
  std::vector<TriangleNumbers> triangles;     ///< [triangle_count]
  std::vector<HingeNumbers> hinges;           ///< [hinge_count]
  std::vector<StiffLinkNumbers> stiff_links;  ///< [link_count] see stiff_links.h
};

/// What materials make of a scene's rest shape.
/// @param edges  [edge_count] from find_edges() of the scene's tetrahedra
[[nodiscard]] ConstraintNumbers numbers_at_rest(const Scene& scene, std::span<const Edge> edges,
                                                ProjectionMode mode);

/// The same of a tissue, where what is dead has no constraints.
[[nodiscard]] ConstraintNumbers numbers_at_rest(const Tissue& tissue, ProjectionMode mode);

/// Of a live hinge, whose triangles are as stiff as they are now.
[[nodiscard]] Numbers<BendingConstraint> hinge_numbers(const Tissue& tissue, Index hinge);

/// @throws InvalidArgument  naming the Neo-Hookean body or the sheet in fraction mode
void check_materials(std::span<const Body> bodies, ProjectionMode mode);

/// @throws InvalidArgument  if there are any in fraction mode
void check_hinges(std::size_t count, ProjectionMode mode);

/// Whether any material has damping.
[[nodiscard]] bool has_damping(std::span<const Body> bodies) noexcept;

[[nodiscard]] Numbers<DistanceConstraint> link_numbers(const Link& link, ProjectionMode mode);

/// Of an edge of a part of a tetrahedron, between corners a and b of the part.
/// @param parent  of its edges, in the order of kTetEdges
/// @param a, b    shares of the parent's corners
[[nodiscard]] EdgeNumbers part_numbers(const std::array<EdgeNumbers, 6>& parent,
                                       const std::array<double, 4>& a,
                                       const std::array<double, 4>& b);

}  // namespace pbdsurg
