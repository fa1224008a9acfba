// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissue parts along faces.

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Moves corners to copies of their vertices. Constraints follow in the colours that they have: two
/// at the copy were both at the vertex. An edge that all its tetrahedra take along keeps its id;
/// where some stay, those that leave get a new one. Cost: proportional to the tetrahedra at the
/// vertices.
void move_corners(SolverData& data, const TopologyEdit& edit, EditResult& result);

/// Moves ends of links to copies of their vertices.
void move_links(SolverData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
