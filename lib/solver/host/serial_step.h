// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A part of a step by one thread: what each operation of a step means.

#include "pbdsurg/solver/step_report.h"

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// SolverData::part of a step of one copy.
/// @param step    whose scratch fits
/// @param report  of the parts before; complete after the last
void step_serially(const StepContext& step, StepReport& report);

}  // namespace pbdsurg
