// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sentences about values outside what soft tissue has.

#include <sstream>
#include <string>
#include <vector>

namespace pbdsurg {

/// "tissue WHAT is VALUE; RULE"
inline std::string tissue_statement(const char* what, double value, const std::string& rule) {
  std::ostringstream text;
  text << "tissue " << what << " is " << value << "; " << rule;
  return text.str();
}

/// Adds a sentence to `found` unless value is in [low, high].
inline void expect_usual(std::vector<std::string>& found, const char* what, double value,
                         double low, double high, const char* unit) {
  if (!(value >= low && value <= high)) {
    std::ostringstream rule;
    rule << "soft tissue has " << low << " to " << high << (*unit != 0 ? " " : "") << unit;
    found.push_back(tissue_statement(what, value, rule.str()));
  }
}

}  // namespace pbdsurg
