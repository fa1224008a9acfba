// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Calls that must be refused with a message.

#include <string>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg::testing {

/// Checks that a call throws InvalidArgument.
/// @param what  a part of its message
template <class Call>
void check_refused(Call call, const std::string& what) {
  CHECK_THROWS_AS(call(), InvalidArgument);
  CHECK_THROWS_WITH(call(), ContainsSubstring(what));
}

}  // namespace pbdsurg::testing
