// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What calls of a solver name, once it is known to be there.

#include "pbdsurg/solver/tool.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the copy that there is not, and how many there are
CopyState& checked_copy(SolverData& data, Index copy);

/// @throws InvalidArgument  naming the tool that there is not, and how many there are
ToolState& checked_tool(CopyState& copy, ToolId tool);

/// @throws InvalidArgument  unless it is a finite translation and a rotation
void check_pose(const ToolPose& pose);

}  // namespace pbdsurg
