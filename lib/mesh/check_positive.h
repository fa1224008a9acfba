// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Refuses quantities that must be positive.

#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

#include "mesh/describe.h"

namespace pbdsurg {

/// @param unit  " m", say, as it follows the number
/// @throws InvalidArgument  naming the quantity and its value, unless that is positive and finite
inline void check_positive(const char* what, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(what) + " is " + describe(value) + unit +
                          "; it must be positive and finite");
  }
}

}  // namespace pbdsurg
