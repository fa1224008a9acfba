// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools and tables against tissue: what closed forms or finer meshes say.

#include <functional>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg::bench {

struct ContactOutcome {
  double value;
  double expected;       ///< zero where value itself is the error
  double error_percent;  ///< of what is expected, or of what the case names
};

struct ContactCase {
  std::string name;
  const char* unit;
  const char* source;    ///< of what is expected
  double limit_percent;  ///< that the error is to keep
  bool is_quick;         ///< takes seconds
  std::function<ContactOutcome(const SolverOptions&)> run;
  double of_projections = 1;  ///< times the limit
};

[[nodiscard]] ContactOutcome compare(double value, double expected);

/// @param unit  what an error of 100 % would be
[[nodiscard]] ContactOutcome compare_to_zero(double value, double unit);

[[nodiscard]] std::vector<ContactCase> contact_cases();

}  // namespace pbdsurg::bench
