// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keys by which constraints are ordered, the same on host and device.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Larger comes first: most constraints at one vertex, then most at all.
/// @param valence  [vertex_count] constraints at each vertex
template <class Ids>
PBDSURG_HOST_DEVICE std::uint64_t valence_key(const Ids& ids, const Index* valence) {
  std::uint64_t most = 0;
  std::uint64_t sum = 0;
  for (const Index v : ids) {
    const auto here = static_cast<std::uint64_t>(valence[v]);
    most = here > most ? here : most;
    sum += here;
  }
  constexpr std::uint64_t kLargest = 0xFFFFFFFFu;
  return (most << 32) | (sum < kLargest ? sum : kLargest);
}

/// A bijection of [0, 2^bits) that looks random: ranks of which no two are equal.
PBDSURG_HOST_DEVICE inline std::uint32_t shuffled_rank(std::uint32_t id, int bits,
                                                       std::uint64_t salt) {
  const std::uint32_t mask = bits >= 32 ? 0xFFFFFFFFu : (1u << bits) - 1;
  const int half = (bits + 1) / 2;
  std::uint32_t x = (id ^ static_cast<std::uint32_t>(salt)) & mask;
  x = (x * 0x9E3779B1u) & mask;
  x ^= x >> half;
  x = (x * 0x85EBCA77u + static_cast<std::uint32_t>(salt >> 32)) & mask;
  x ^= x >> half;
  x = (x * 0xC2B2AE3Du) & mask;
  return x ^ (x >> half);
}

}  // namespace pbdsurg
