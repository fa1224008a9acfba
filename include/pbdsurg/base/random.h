// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Counter-based random numbers: a value depends on (seed, element, round) alone, never on who asks
/// first, so a parallel algorithm gives one answer on any number of threads and on any device.

#include <cstdint>

#include "pbdsurg/base/host_device.h"

namespace pbdsurg {

namespace detail {

/// The SplitMix64 finaliser (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number
/// generators") of a state advanced by one word.
PBDSURG_HOST_DEVICE constexpr std::uint64_t mix_bits(std::uint64_t state, std::uint64_t word) {
  state += word + 0x9E3779B97F4A7C15u;
  state = (state ^ (state >> 30)) * 0xBF58476D1CE4E5B9u;
  state = (state ^ (state >> 27)) * 0x94D049BB133111EBu;
  return state ^ (state >> 31);
}

}  // namespace detail

/// 64 well-mixed bits for one (seed, element, round).
PBDSURG_HOST_DEVICE constexpr std::uint64_t random_bits(std::uint64_t seed, std::uint64_t element,
                                                        std::uint64_t round = 0) {
  return detail::mix_bits(detail::mix_bits(detail::mix_bits(0, seed), element), round);
}

/// A number in [0, 1) for one (seed, element, round).
PBDSURG_HOST_DEVICE constexpr double random_unit(std::uint64_t seed, std::uint64_t element,
                                                 std::uint64_t round = 0) {
  return static_cast<double>(random_bits(seed, element, round) >> 11) * 0x1.0p-53;
}

}  // namespace pbdsurg
