// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace pbdsurg::cuda {

/// How often a thread of the following steps looks for a neighbour before it gives the step up:
/// some half a second on an H100. Less only in tests of what happens then.
inline std::atomic<std::uint32_t> longest_wait{1U << 20};

}  // namespace pbdsurg::cuda
