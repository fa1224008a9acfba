// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What edits add to a solver's data.

#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/solver/step_plan.h"

#include "solver/constraint_numbers.h"
#include "solver/solver_data.h"

namespace pbdsurg {

/// A group that a new constraint may join: the first of its type that is projected in parallel,
/// holds for the whole scene and has no constraint at any of some vertices; if there is none, one
/// that is opened behind the others of its type. Cost: proportional to the constraints at the
/// vertices and to the groups that hold for the whole scene.
/// @param kind  distance, volume, neo_hookean or strain_limit
Index find_free_group(SolverData& data, PhaseKind kind, std::span<const Index> vertices);

/// Groups for constraints at vertices that have none, as many as asked for: those that a new
/// constraint may join, in their order, and where these are too few, some that are opened.
[[nodiscard]] std::vector<Index> groups_to_join(SolverData& data, PhaseKind kind, Index count);

/// Adds a vertex to all copies that moves as the point on a segment, without mass yet. It is fixed
/// if both ends are.
/// @param share  of the way from `first` to `second`
void add_vertex(SolverData& data, Index first, Index second, float share);

/// Adds an edge that follows the others, without tetrahedra and constraints yet.
/// @return  its id
Index add_edge(SolverData& data, const Edge& ends);

/// Of an edge, as they are now.
[[nodiscard]] EdgeNumbers numbers_of(const SolverData& data, Index edge);

[[nodiscard]] TetNumbers tet_numbers_of(const SolverData& data, Index tet);

/// Gives an edge its constraints, once tetrahedra have it.
void add_edge_constraints(SolverData& data, Index edge, const EdgeNumbers& numbers);

/// Adds a live tetrahedron that follows the others, without edges, vertices' lists, mass at its
/// vertices and constraints yet.
/// @param mass  kg
/// @return      its id
Index add_tet(SolverData& data, const Tet& vertices, Index body, double mass);

/// Adds a link that follows the others, with its constraint.
void add_link(SolverData& data, const Link& link);

/// After an edit that added anything, or gave constraints other vertices: tells backends, and
/// rebuilds the rows of the vertex-block method. Cost: that of this method O(tets), else constant.
void finish_growth(SolverData& data);

/// Takes back what the edit at hand added; constraints have gone already.
void undo_growth(SolverData& data);

/// Makes room for what a tool can touch, so that no step allocates; of all tools for the latter.
void reserve_tool(const SolverData& data, ToolState& tool);
void reserve_tools(SolverData& data);

/// Makes the room that options ask for.
void reserve_spare_room(SolverData& data);

}  // namespace pbdsurg
