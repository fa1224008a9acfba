// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Phases of a sweep by one thread, one constraint after another: all of the serial backend's work,
/// and what is too small or too ordered for others to share out.

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_plan.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Executes one phase, in the mode of the options.
void project_serially(const StepContext& step, const Phase& phase, const Substep<float>& substep);

}  // namespace pbdsurg
