// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold a slab against a pull: whether they slip, hold and let it tear where they should.

#include <vector>

#include "bench/contact/cases.h"

namespace pbdsurg::bench {

[[nodiscard]] std::vector<ContactCase> grasp_cases();

}  // namespace pbdsurg::bench
