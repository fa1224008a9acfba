// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From bodies, materials and links to constraints in the order of the plan.

#include "pbdsurg/solver/scene.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Makes all constraints, colours them and lists the phases that there can be.
/// @param data  with options, bodies and topology
void build_constraints(const Scene& scene, SolverData& data);

}  // namespace pbdsurg
