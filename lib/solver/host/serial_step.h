// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step by one thread: what each operation of a step means.

#include "pbdsurg/solver/step_report.h"

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// A whole step of one copy, of SolverData::division.
/// @param step  whose scratch fits
/// @param dt    s
[[nodiscard]] StepReport step_serially(const StepContext& step, float dt);

}  // namespace pbdsurg
