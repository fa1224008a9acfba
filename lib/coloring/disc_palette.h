// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sizes of random_disc's tables and palettes, the same on host and device.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/coloring/random_disc.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option out of range
void check_disc_options(const RandomDiscOptions& options);

/// Seed of one of several windows of colours.
constexpr std::uint64_t window_seed(std::uint64_t seed, int window) {
  return seed + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(window);
}

/// How many other constraints share a vertex with constraint c.
/// @param offsets, entries  the constraints at each vertex
template <class Access>
PBDSURG_HOST_DEVICE Index count_conflicts(const Access& constraints, Index c, const Index* offsets,
                                          const Index* entries) {
  const auto ids = constraints[c];
  Index count = 0;
  for (int i = 0; i < ids.size(); ++i) {
    for (Index e = offsets[ids[i]]; e < offsets[ids[i] + 1]; ++e) {
      // one that shares several vertices counts at the first of them
      bool counted = entries[e] == c;
      const auto others = constraints[entries[e]];
      for (int j = 0; j < i && !counted; ++j) {
        for (const Index v : others) {
          counted = counted || v == ids[j];
        }
      }
      count += counted ? 0 : 1;
    }
  }
  return count;
}

/// Colours that a constraint starts with in Palette::conflicts.
PBDSURG_HOST_DEVICE inline Index palette_for(Index conflicts, double shrink) {
  return 1 + static_cast<Index>(static_cast<double>(conflicts) / shrink);
}

}  // namespace pbdsurg
