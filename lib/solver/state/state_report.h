// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a step has to report of the state that it leaves.

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_report.h"

namespace pbdsurg {

struct CopyState;
class SolverData;

/// Vertices that are not finite.
void report_vertices(const SolverData& data, const CopyState& copy, StepReport& report);

/// Residuals of all constraints, and inverted tetrahedra among those that have volume constraints
/// or are Neo-Hookean.
void report_constraints(const SolverData& data, const CopyState& copy, StepReport& report);

/// Inverted tetrahedra of tubes, which have no volume constraints.
void report_tubes(const SolverData& data, const CopyState& copy, StepReport& report);

/// Keeps what a copy reports, and adds it to what those before it do.
PBDSURG_API void report_copy(Index index, const StepReport& of_copy, CopyState& copy,
                             StepReport& report);

}  // namespace pbdsurg
