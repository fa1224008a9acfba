// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools that a spring ties to where they are to be. Such a tool has no mass, so it is always where
/// the spring bears the multipliers of its contacts,
///
///     d = -w sum(lambda n + friction),    w = compliance / dt^2    1/kg,
///
/// with d its displacement: it is one more corner of each of its contacts, with a weight of -1 and
/// an inverse mass of w. Projections move it with every push. Vertex blocks find it after each
/// sweep, by Newton's method, as the forces of contacts follow d. Capsules are placed, and contacts
/// found, with the displacement of the substep before; `shift` is what has been added since.

#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/tool_state.h"

namespace pbdsurg {

/// Before a substep's contacts are met: see begin_spring().
void begin_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool);

/// After a sweep of vertex blocks: see balance_spring().
void balance_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool);

/// After a substep: see end_spring().
void end_coupling(const StepContext& step, ToolState& tool);

}  // namespace pbdsurg
