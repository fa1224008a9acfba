// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What makes a run less than the operation that it plays.

#include <optional>
#include <string>

namespace cholecystectomy {

/// As in `warnings[]` of the report.
struct Warning {
  std::string code;             ///< for programs: "few_links"
  std::string text;             ///< for people, a sentence
  std::optional<double> value;  ///< what the text counts or measures
  bool is_failure = false;      ///< the run was not the operation: exit status 1
};

}  // namespace cholecystectomy
