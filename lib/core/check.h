// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Checks of what callers give.

#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming what is not in [low, high], or is no number
inline void check_range(const char* what, double value, double low, double high) {
  if (!(value >= low) || !(value <= high)) {
    throw InvalidArgument(std::string(what) + " is " + std::to_string(value) + "; it must be in [" +
                          std::to_string(low) + ", " + std::to_string(high) + "]");
  }
}

}  // namespace pbdsurg
