// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edits that must be refused.

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// Puts one thing into a good edit that breaks a rule of Tissue::apply() or of a solver.
void spoil(const Solver& solver, Choices& choices, TopologyEdit& edit);

}  // namespace pbdsurg::testing
