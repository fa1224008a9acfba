// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bodies that come into a solver that runs.

#include "pbdsurg/solver/scene.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Adds a scene's bodies behind all that is there, at rest, in all copies. Constraints
/// are coloured as those of a scene of their own, and take the groups that there are, because they
/// share no vertex with what is there. Cost: that of colouring, and proportional to the bodies.
/// @param scene  one that fits: see apply_edit()
void add_bodies(SolverData& data, const Scene& scene);

/// Takes back that the edit at hand added bodies, once their tissue has gone.
void undo_bodies(SolverData& data);

}  // namespace pbdsurg
