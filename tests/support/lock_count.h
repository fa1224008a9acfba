// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Counts the locks of mutexes in the whole program that has its source: none where a sanitizer,
/// which has locks of its own, is on.

#include <atomic>

namespace pbdsurg::testing {

extern std::atomic<long> lock_count;                     ///< but of the mutex that is left out
extern std::atomic<const void*> last_locked_mutex;       ///< by its address
extern std::atomic<const void*> mutex_that_is_left_out;  ///< likewise

}  // namespace pbdsurg::testing
