// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From edges, tetrahedra and links to constraints in the order of the plan.

#include "lib/solver/sets/constraint_numbers.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Makes all constraints, colours them and lists the phases that there can be.
/// @param numbers  of edges and tetrahedra
/// @param data     with options, bodies, topology and places
void build_constraints(const ConstraintNumbers& numbers, SolverData& data);

}  // namespace pbdsurg
