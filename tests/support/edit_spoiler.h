// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edits that must be refused.

#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/solver/solver.h"

#include "support/choices.h"

namespace pbdsurg::testing {

/// Puts one thing into a good edit that breaks a rule of apply_edit().
void spoil(const Solver& solver, Choices& choices, TopologyEdit& edit);

}  // namespace pbdsurg::testing
