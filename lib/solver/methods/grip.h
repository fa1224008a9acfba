// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold with a limit, within a step. Each point x of what they hold is drawn to its
/// anchor by a spring; all anchors may slide along the pad by one way s, against which the jaws rub
/// with at most F = 2 mu N. So what a substep minimises has the terms
///
///     sum(k / 2 |target + s - x|^2) + F |s|        k = 1 / compliance
///
/// and s, for points where they are, is what brings the sum of pulls along the pad back to F:
///
///     s = -(1 - F / |P|) P / (n k)   if |P| > F, else 0      P = k sum(target - x) along the pad
///
/// At the end of the substep anchors have slid in the tool's frame. This is return mapping of
/// perfect plasticity (Simo and Hughes 1998, 3.3), with the patch of points as one element.

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/grip_motion.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Clears what a step sums up.
PBDSURG_API void begin_grip(ToolGrip& grip);

/// Puts targets where the tool is in a substep.
void place_grip(ToolGrip& grip, const ToolPose& pose);

/// @param pose  of its tool in a substep, for which it has been placed
[[nodiscard]] PBDSURG_API GripPose grip_pose(const ToolGrip& grip, const ToolPose& pose);

/// N, the most that jaws rub with, as a substep takes it: see substep_numbers().
[[nodiscard]] PBDSURG_API float limit_of(const CopyState& copy, const ToolGrip& grip) noexcept;

/// m/N, of each point of a grip, as a substep takes it: see substep_numbers().
[[nodiscard]] PBDSURG_API float compliance_of(const CopyState& copy, const ToolGrip& grip) noexcept;

/// m, from where a point is now to where jaws want it.
[[nodiscard]] Vec3<float> way_to_jaws(const StepContext& step, const ToolGrip& grip,
                                      const GripPoint& point);

/// The phase of all grips, at the end of a sweep of projections.
void project_grips(const StepContext& step, const Substep<float>& lengths);

/// Of vertex blocks, before the sweeps: what slid goes on sliding.
void begin_grips(const StepContext& step);

/// The phase of all grips, at the end of a sweep of vertex blocks. A vertex that follows its spring
/// does not know that the anchors follow it, too: so where they slide, all vertices of the patch
/// move together to where tissue balances F, as far as each could alone.
void answer_grips(const StepContext& step, const Substep<float>& lengths);

/// Adds the substep's share to what the tool feels, and moves the anchors by what slid.
/// @param scale  1/s^2, force per multiplier
void collect_grip(ToolState& tool, float scale);

/// After a step: lets go of what left the pads or tore, in all copies.
void end_grips(SolverData& data);

}  // namespace pbdsurg
