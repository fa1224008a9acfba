// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools within a step: where they are in each substep, what they touch, what pushes back.

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Clears the forces of the last step.
void begin_tools(CopyState& copy);

/// Puts capsules and the targets of grasped vertices where the tools are at a fraction (0, 1] of
/// the step, and clears multipliers.
PBDSURG_API void place_tools(CopyState& copy, float fraction);

/// What holds all that touches a tool.
[[nodiscard]] PBDSURG_API ContactBox contact_box(const std::vector<Capsule>& placed_capsules);

/// Finds the vertices near each tool's capsules: one contact a vertex and tool, the deepest, in
/// ascending order of places, at most the contact capacity. Cost: O(vertices * capsules).
void find_contacts(const StepContext& step, StepReport& report);

/// Adds the substep's share of the multipliers to the tools' forces, those that are finite.
/// @param force_per_multiplier  1/s^2
void collect_tool_forces(CopyState& copy, float force_per_multiplier);

/// Makes the targets of this step the poses of the next.
PBDSURG_API void end_tools(CopyState& copy);

}  // namespace pbdsurg
