// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hooks at rest in soft tissue, thinner than its edges: whether it comes to rest, too, and whether
/// their force depends on the steps.

#include <vector>

#include "bench/contact/cases.h"

namespace pbdsurg::bench {

[[nodiscard]] std::vector<ContactCase> hook_cases();

}  // namespace pbdsurg::bench
