// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Nothing of sheets and threads passes a tool that meets edges and triangles: see passing.h.

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// Whether stop_passing() has anything to look at.
[[nodiscard]] bool may_stop(const StepContext& step) noexcept;

/// Takes along what has come through tools, once all else has moved vertices, and notes what that
/// pushed for collect_tool_forces(). What is fixed stays; a triangle or an edge with a fixed corner
/// may pass in the end, as the others alone do not keep it.
///
/// Cost: O(triangles of sheets and links) and, where anything of these has moved as far as through
/// a tool, as much a few times more.
void stop_passing(const StepContext& step);

}  // namespace pbdsurg
