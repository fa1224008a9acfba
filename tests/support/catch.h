// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The one include of all tests: hides the difference between Catch2 2.13 and 3.

#include <string>

#if defined(PBDSURG_CATCH2_3)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif

namespace pbdsurg::testing {

#if defined(PBDSURG_CATCH2_3)
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;
#else
using Catch::Detail::Approx;
inline auto ContainsSubstring(const std::string& text) {
  return Catch::Matchers::Contains(text);
}
#endif

}  // namespace pbdsurg::testing
