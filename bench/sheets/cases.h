// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sheets at rest, or on their way there, whose shape a closed form gives.

#include <functional>
#include <vector>

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg::bench {

/// What a solver comes to, and what it should.
struct SheetOutcome {
  double value, expected;
};

struct SheetCase {
  const char* name;
  const char* unit;
  const char* source;  ///< of the closed form
  std::function<SheetOutcome(SolverOptions)> run;
};

[[nodiscard]] const std::vector<SheetCase>& sheet_cases();

}  // namespace pbdsurg::bench
