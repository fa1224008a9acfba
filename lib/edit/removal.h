// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What goes in an edit, with all that only it held.

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

void remove_link(SolverData& data, Index link, EditResult& result);

/// Removes a tetrahedron and edges that it was the last to use.
void remove_tet(SolverData& data, Index tet, EditResult& result);

/// A vertex loses a tetrahedron; without any it stops.
void take_from_vertex(SolverData& data, Index vertex, Index tet, EditResult& result);

/// Vertices whose tetrahedra changed get a quarter of the mass of each that they have now: summed,
/// for what is left after subtracting may be rounding alone where slivers remain.
/// Cost: proportional to the tetrahedra at these vertices.
void sum_masses(SolverData& data);

/// Links and tools let go of vertices without tissue.
void release_vertices(SolverData& data, EditResult& result);

}  // namespace pbdsurg
