// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools and sheets: what must not pass, and a belt around a pulley.

#include <vector>

#include "bench/contact/cases.h"

namespace pbdsurg::bench {

[[nodiscard]] std::vector<ContactCase> sheet_cases();

}  // namespace pbdsurg::bench
