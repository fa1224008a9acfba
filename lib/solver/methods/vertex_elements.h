// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tissue and its constraints add to the energy of vertices, element by element.

#include <span>
#include <vector>

#include "pbdsurg/tissue/material.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg {

class SolverData;

/// What live tetrahedra add to the energy; their vertices and fibres are left out. [tet_count]
[[nodiscard]] std::vector<VertexTet> vertex_tets_at_rest(const Tissue& tissue);

/// As the constraints of a tetrahedron have it; nothing if it is gone.
[[nodiscard]] VertexTet vertex_tet(const SolverData& data, const Tissue& tissue, Index tet);

/// Gives one the fibres that its constraints have.
void set_fibre(const SolverData& data, Index id, VertexTet& tet);

/// One that has another volume at rest, m^3; its fibres are what they were.
[[nodiscard]] VertexTet resized(VertexTet tet, const Material& material, float rest_volume);

/// As the constraints of an edge, a link, a triangle, a hinge have it; nothing if they are gone.
[[nodiscard]] VertexSpring edge_spring(const SolverData& data, const Tissue& tissue, Index edge);
[[nodiscard]] VertexSpring link_spring(const SolverData& data, const Tissue& tissue, Index link);
[[nodiscard]] VertexTriangle vertex_triangle(const SolverData& data, const Tissue& tissue,
                                             Index triangle);
[[nodiscard]] VertexHinge vertex_hinge(const SolverData& data, const Tissue& tissue, Index hinge);

/// m, about that of a tetrahedron of such a volume.
[[nodiscard]] double edge_of_volume(double volume);

/// m, of fixed points: a power of two such that neighbours may be apart by 128 of the longest
/// edges, of triangles, too, or links along each axis.
[[nodiscard]] float choose_unit(const Tissue& tissue, std::span<const VertexTet> tets,
                                std::span<const VertexSpring> springs);

/// A unit made larger, where that is too small for something as long, m.
[[nodiscard]] float wide_enough(float unit, double length);

/// Likewise for what an edit has brought.
[[nodiscard]] float wide_enough(float unit, const Tissue& tissue, const TissueChange& change,
                                std::span<const VertexTet> tets,
                                std::span<const VertexSpring> springs);

}  // namespace pbdsurg
