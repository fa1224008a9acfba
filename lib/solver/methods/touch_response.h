// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How bodies answer each other in a substep: as they answer tools, see surface_contacts.h, but
/// with four corners, on which the same force acts both ways. So projections keep momentum, and,
/// without friction, its moment: friction acts across the thickness, and has that much of a lever.
///
/// In vertex blocks both sides move at the same time, as a vertex and a triangle may have a colour
/// in common: each sees the other where it was when the sweep began. The stiffness of a contact is
/// that of both sides together, so what they do at once is not too much.

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/contact_answer.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/tissue_touch.h"

namespace pbdsurg {

/// Where a contact is now.
[[nodiscard]] ContactReading<float> read_touch(const MovingVertices& vertices,
                                               const TissueTouch& touch);

/// Of vertex blocks, once it is known what holds each vertex: how stiffly bodies meet.
void begin_touches(const StepContext& step, const VertexState& state);

/// Of vertex blocks, where vertices have moved without a sweep.
void see_touches(const StepContext& step);

/// What a contact does at a corner that moves, of vertex blocks.
/// @param corner  of the contact
void add_touch(const StepContext& step, const TissueTouch& touch, int corner,
               float inverse_dt_squared, VertexEnergy<float>& energy);

/// Projects contacts in their order.
void project_touches(const StepContext& step);

/// The phase of contacts between bodies, at the end of a sweep: projects them; of vertex blocks,
/// balances what touches each other or a tool, see touched_pieces.h, and takes over
/// their forces.
void answer_touches(const StepContext& step, const Substep<float>& lengths);

/// After all sweeps of vertex blocks: parts what is still too near, and joins the momentum of what
/// pushes each other: see pushed_pieces.h.
void settle_touches(const StepContext& step);

}  // namespace pbdsurg
