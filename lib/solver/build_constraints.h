// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From bodies, materials and links to constraints in the order of the plan.

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/scene.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// What a projection takes: a fraction, or a compliance, m/N.
[[nodiscard]] float stiffness_in(ProjectionMode mode, const Stiffness& stiffness) noexcept;

/// Makes all constraints, colours them and lists the phases that there can be.
/// @param data  with options, bodies and topology
void build_constraints(const Scene& scene, SolverData& data);

}  // namespace pbdsurg
