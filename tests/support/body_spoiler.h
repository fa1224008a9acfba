// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edits of whole bodies that must be refused.

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// Puts one thing into an edit that breaks a rule of bodies that come or go.
/// @return  whether it found what it needs
[[nodiscard]] bool spoil_bodies(const Solver& solver, Choices& choices, TopologyEdit& edit);

}  // namespace pbdsurg::testing
