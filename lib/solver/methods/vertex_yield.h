// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a vertex gives way to what pushes it, on a host.

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// m/N along a direction, of a vertex with holds that its neighbours hold, too; 0 of others, which
/// are fixed. Found once for each vertex, from gather_holds() on.
[[nodiscard]] float yield_of(const StepContext& step, const VertexState& state, Index place,
                             const Vec3<float>& direction);

}  // namespace pbdsurg
