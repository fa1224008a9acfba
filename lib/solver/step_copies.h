// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step of all copies, with a backend that steps one.

#include "solver/backend.h"

namespace pbdsurg {

/// Steps all copies one after another, with a backend that works on the arrays of SolverData.
/// @return  see Solver::step()
StepReport step_copies(SolverData& data, Backend& backend, float dt);

}  // namespace pbdsurg
