// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Checks of what callers give.

#include <cmath>
#include <cstddef>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"

namespace pbdsurg {

/// Allocates nothing where the rule holds: hot paths check, too.
/// @param rule  as in "it must be positive"
/// @throws InvalidArgument  naming the quantity, its value and the rule, unless that holds
inline void check(bool holds, const char* what, double value, const char* rule) {
  if (!holds) {
    throw InvalidArgument(std::string(what) + " is " + describe(value) + "; it must be " + rule);
  }
}

/// @param unit  " m", say, as it follows the number
/// @throws InvalidArgument  naming the quantity and its value, unless that is positive and finite
inline void check_positive(const char* what, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(what) + " is " + describe(value) + unit +
                          "; it must be positive and finite");
  }
}

/// @throws InvalidArgument  as above, unless the value is a finite number and not negative
inline void check_not_negative(const char* what, double value) {
  check(value >= 0 && std::isfinite(value), what, value, "finite and not negative");
}

/// @throws InvalidArgument  as above, unless the value is in [low, high]
inline void check_range(const char* what, double value, double low, double high) {
  if (!(value >= low) || !(value <= high)) {
    throw InvalidArgument(std::string(what) + " is " + describe(value) + "; it must be in [" +
                          describe(low) + ", " + describe(high) + "]");
  }
}

/// @throws InvalidArgument  naming the id, unless it is in [0, count)
inline void check_id(const char* what, long long id, std::size_t count) {
  if (id < 0 || static_cast<unsigned long long>(id) >= count) {
    throw InvalidArgument(std::string("there is no ") + what + " " + std::to_string(id) +
                          "; ids must be in [0, " + std::to_string(count) + ")");
  }
}

}  // namespace pbdsurg
