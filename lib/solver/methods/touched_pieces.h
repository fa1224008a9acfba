// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that surfaces of tools touch, of the vertex-block method. A sweep moves a vertex by
/// what its neighbours leave it, which is far less than how a whole piece has to go, so sweeps that
/// end early would hold to the surface what should slide on it. So the piece moves as a rigid body,
/// too: see rigid_balance.h.
///
/// What a tool holds or touches without a surface has no such motion, and neither has what custom
/// constraints push from outside. One after another, in one order, by one thread. Cost, after each
/// sweep: two passes over the vertices of touched pieces and some twenty over their contacts, which
/// is a sixth of the step of a flat block that lies on a third of its vertices.

#include "pbdsurg/constraints/projection.h"

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// Before contacts take over their forces, at the end of a sweep: moves each touched piece to where
/// these forces are what its momentum has changed by.
/// @param lengths  of the substep
void balance_pieces(const StepContext& step, const Substep<float>& lengths);

/// At the end of a substep of BDF2: as eased() (displacement.h) does for vertices, makes each
/// touched piece no faster away from what pushes it than on its way, and forget that it became so.
/// It goes by the rigid motion that the pushes of its contacts give it, and tools feel the momentum
/// that this takes.
void ease_pieces(const StepContext& step);

}  // namespace pbdsurg
