// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How steady a machine's processors are.

#include <vector>

namespace pbdsurg::bench {

/// Walks through 1 MiB of memory, one begun every 2 ms, that do always the same and nothing of this
/// library: where some take several times as long as most, the machine is slow then, not a program.
/// @return  ms, of each
[[nodiscard]] std::vector<double> walk_times(double seconds);

}  // namespace pbdsurg::bench
