// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Counts and limits the allocations of the whole program that has its source: none where a
/// sanitizer, which has allocators of its own, is on.

#include <atomic>
#include <limits>

namespace pbdsurg::testing {

inline constexpr long kNoLimit = std::numeric_limits<long>::max();

extern std::atomic<long> allocation_count;
extern std::atomic<long> allocation_limit;  ///< of the count; beyond, bad_alloc

}  // namespace pbdsurg::testing
