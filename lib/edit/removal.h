// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What goes in an edit, with all that only it held.

#include <span>

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Asks for the memory that removals will need all at once: it lies scattered, and an edit would
/// spend most of its time waiting for one part after the other.
/// @param tets  live
void prefetch_removals(const SolverData& data, std::span<const Index> tets);

void remove_link(SolverData& data, Index link, EditResult& result);

/// Removes a tetrahedron and edges that it was the last to use.
void remove_tet(SolverData& data, Index tet, EditResult& result);

/// A vertex loses a tetrahedron; without any it stops.
void take_from_vertex(SolverData& data, Index vertex, Index tet, EditResult& result);

/// Removes all tissue of a body: what it came with, and what edits split off it.
void remove_body(SolverData& data, Index body, EditResult& result);

/// Vertices whose tetrahedra changed get a quarter of the mass of each that they have now: summed,
/// for what is left after subtracting may be rounding alone where slivers remain.
/// Cost: proportional to the tetrahedra at these vertices.
void sum_masses(SolverData& data);

/// Links and tools let go of vertices without tissue.
void release_vertices(SolverData& data, EditResult& result);

}  // namespace pbdsurg
