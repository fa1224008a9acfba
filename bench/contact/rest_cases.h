// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools that stay where they are, and whether single steps feel the same there: plates, tools on
/// springs, and a membrane between a tool and an organ.

#include <vector>

#include "bench/contact/cases.h"

namespace pbdsurg::bench {

[[nodiscard]] std::vector<ContactCase> rest_cases();

}  // namespace pbdsurg::bench
