// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Custom constraints within a substep, on a host.

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/custom_constraints.h"

#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// Whether there are sets of them.
[[nodiscard]] bool has_custom(const StepContext& step) noexcept;

/// Of the vertex-block method, once it is known how vertices give way: finds the forces with which
/// sweeps begin, of one set after another, and makes them loads. The others begin with their first
/// sweep.
void begin_custom(const StepContext& step, const Substep<float>& lengths);

/// Whether a vertex that a set has named was pushed in this substep, likewise.
[[nodiscard]] bool is_pushed(const StepContext& step, Index place) noexcept;

/// Projects a set in a sweep.
void project_custom(const StepContext& step, Index set, const Substep<float>& lengths, int sweep);

}  // namespace pbdsurg
