// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools within a step: where they are in each substep, what they touch, what pushes back.

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Clears the forces of the last step.
void begin_tools(CopyState& copy);

/// Puts capsules where a tool has them.
/// @param fraction  of the step that its joints have turned
void place_capsules(const ToolState& tool, const ToolPose& pose, float fraction,
                    std::vector<Capsule>& placed);

/// Puts capsules and the targets of grasped vertices where the tools and their joints are at a
/// fraction (0, 1] of the step, and clears multipliers. All else knows placed capsules alone.
/// @param before  where they were at the substep's start, which those that meet surfaces want
PBDSURG_API void place_tools(CopyState& copy, float fraction, float before = 0);

/// What holds all that touches a tool.
[[nodiscard]] PBDSURG_API ContactBox contact_box(const std::vector<Capsule>& placed_capsules);

/// Finds what each tool touches, at most the contact capacity: of surfaces, see
/// find_surface_contacts(); of others the vertices near their capsules, the deepest for each, in
/// ascending order of places. Cost: O(vertices * capsules). Then what bodies touch of each other,
/// see find_touches().
/// @param lengths  of the substep
void find_contacts(const StepContext& step, const Substep<float>& lengths, StepReport& report);

/// Adds the substep's share of the multipliers to the tools' forces and torques, those that are
/// finite.
/// @param force_per_multiplier  1/s^2
PBDSURG_API void collect_tool_forces(const StepContext& step, float force_per_multiplier);

/// Adds to what a tool feels: a force on tissue, N, at a point of the scene. A vertex that is lost
/// has none.
void feel(const Eigen::Vector3f& force, const Eigen::Vector3f& point, ToolState& tool);

/// Adds to what a tool feels where a contact is: `scale` times a push on what it touches, kg m.
void feel_contact(const SurfaceContact& contact, const Vec3<float>& push, float scale,
                  ToolState& tool);

/// Keeps what the next substep has to know of contacts.
/// @param lengths  of this substep
void remember_contacts(const StepContext& step, const Substep<float>& lengths);

/// Makes the targets of this step the poses and joints of the next.
PBDSURG_API void end_tools(CopyState& copy);

}  // namespace pbdsurg
