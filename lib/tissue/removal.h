// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What goes in an edit, with all that only it held.

#include <span>

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Asks for the memory that removals will need all at once: it lies scattered, and an edit would
/// spend most of its time waiting for one part after the other.
/// @param tets  live
void prefetch_removals(const TissueData& data, std::span<const Index> tets);

void remove_link(TissueData& data, Index link);

/// Removes a tetrahedron, its hinges and edges that it was the last to use.
void remove_tet(TissueData& data, Index tet);

/// Likewise, but for its hinges.
void take_out_tet(TissueData& data, Index tet);

/// A vertex loses a tetrahedron; without any it stops.
void take_from_vertex(TissueData& data, Index vertex, Index tet);

/// Removes a triangle of a sheet and its hinges.
void remove_triangle(TissueData& data, Index triangle);

/// A vertex loses a triangle; without any it stops.
void take_triangle_from_vertex(TissueData& data, Index vertex, Index triangle);

/// Removes all tissue of a body: what it came with, and what edits split off it.
void remove_body(TissueData& data, Index body);

/// Vertices whose tetrahedra or triangles changed get their share of each that they have now:
/// summed, for what is left after subtracting may be rounding alone where slivers remain. Cost:
/// proportional to what is at these vertices.
void sum_masses(TissueData& data);

/// Removes the links of vertices without tissue.
void remove_links_of_emptied(TissueData& data);

}  // namespace pbdsurg
