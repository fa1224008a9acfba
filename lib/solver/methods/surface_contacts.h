// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How vertices, edges and triangles answer a tool in a substep. Projections move their corners out
/// of the tool by their masses. Vertex blocks meet a spring at each corner, whose force a
/// multiplier takes over after each sweep (augmented Lagrangian, Hestenes 1969, Powell 1969): with
/// the gap C, the slip s along the tool, and the stiffness k,
///
///     lambda = max(0, lambda - k C)         friction = friction - k s, no longer than mu lambda
///
/// so the multipliers converge to the forces that keep C >= 0 and, inside the cone, s = 0. Before
/// that, what nothing else holds moves rigidly to where these forces balance: see touched_pieces.h.
/// After it, planes are turned to where their features are: see turn_to(). What the last sweep
/// leaves of C < 0, corners are moved out of by their masses, in a few passes. Projections keep the
/// planes of the start of their substeps, which are short.

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/contact_answer.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/tool_state.h"

namespace pbdsurg {

/// Where a contact is now.
/// @param shift  m, of its tool: see ToolSpring
[[nodiscard]] ContactReading<float> read_contact(const MovingVertices& vertices,
                                                 const SurfaceContact& contact,
                                                 const Vec3<float>& shift);
[[nodiscard]] inline ContactReading<float> read_contact(const MovingVertices& vertices,
                                                        const SurfaceContact& contact,
                                                        const ToolState& tool) {
  return read_contact(vertices, contact, tool.spring.shift);
}

/// Whether a tool meets surfaces: see ToolState::has_surface().
[[nodiscard]] bool meets_surfaces(const StepContext& step) noexcept;

/// Of vertex blocks, once it is known what holds each vertex: how stiffly contacts are met.
void begin_surface_contacts(const StepContext& step, const VertexState& state);

/// What a contact does at a corner that moves, of vertex blocks.
/// @param corner  of the contact
void add_surface_contact(const StepContext& step, const SurfaceContact& contact, int corner,
                         const ToolState& tool, float inverse_dt_squared,
                         VertexEnergy<float>& energy);

/// The phase of a tool's contacts, at the end of a sweep of projections.
void project_surface_contacts(const StepContext& step, Index tool);

/// That of all contacts, at the end of a sweep of vertex blocks: balances what they touch, see
/// touched_pieces.h, unless contacts between bodies have done so, and tools that springs hold, see
/// coupled_tool.h, takes over their forces, and turns their planes.
void answer_surface_contacts(const StepContext& step, const Substep<float>& lengths);

/// Of explicit steps, how often contacts are gone through after vertices have been pushed.
inline constexpr int kPushPasses = 4;

/// Of explicit steps: all contacts, once vertices have been pushed; those of tools last.
void push_out_of_surfaces(const StepContext& step);

/// After all sweeps of vertex blocks: moves what is still inside of tools out of them.
void settle_surface_contacts(const StepContext& step);

}  // namespace pbdsurg
