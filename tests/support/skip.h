// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tests that a machine cannot run. Catch2 2.13 knows none, so main.cpp counts them and leaves with
/// a code that ctest shows as skipped. They have a tag of their own, and so an entry of ctest's
/// (PARTS of pbdsurg_add_test).

#include <string>

#include "tests/support/catch.h"

namespace pbdsurg::testing {

inline int skipped = 0;

/// To be followed by a return.
inline void skip(const std::string& reason) {
  ++skipped;
  WARN("skipped: " << reason);
}

}  // namespace pbdsurg::testing
