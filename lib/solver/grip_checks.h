// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What calls of a solver say of grips.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/solver/grip.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// @throws InvalidArgument  if the solver takes explicit steps
void check_takes_grips(const SolverData& data);

/// @throws InvalidArgument  naming the value out of range
PBDSURG_API void check_pad(const JawPad& pad);

/// @throws InvalidArgument  likewise
void check_grip(const Grip& grip);

/// @throws InvalidArgument  unless it is finite and not negative
void check_clamp_force(float force);

/// @throws InvalidArgument  naming the point whose vertices there are not, are no vertex, edge or
///                          face, or whose weights are out of range
void check_points(const Tissue& tissue, std::span<const TissuePoint> points);

/// @throws InvalidArgument  if the tool holds something
void check_holds_nothing(const ToolState& tool, ToolId id);

/// Whether there are three places at least that are not on a line.
[[nodiscard]] PBDSURG_API bool can_be_held(std::span<const Eigen::Vector3f> places);

/// Of a grip from elsewhere.
/// @throws InvalidArgument  as above, and naming the jaw that there is not or the point that is not
///                          finite
void check_grip_state(const SolverData& data, const ToolGrip& grip, std::size_t tool_count);

}  // namespace pbdsurg
