// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bits of a 64-bit word, on host and device.

#include <bit>
#include <cstdint>

#include "pbdsurg/core/host_device.h"

namespace pbdsurg {

/// How many bits are set.
PBDSURG_HOST_DEVICE inline int count_bits(std::uint64_t word) {
#if defined(__CUDA_ARCH__)
  return __popcll(static_cast<long long>(word));
#else
  return std::popcount(word);
#endif
}

/// Position of the lowest set bit of a word that is not zero.
PBDSURG_HOST_DEVICE inline int lowest_bit(std::uint64_t word) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(word)) - 1;
#else
  return std::countr_zero(word);
#endif
}

/// Position of the set bit that has `rank` set bits below it; there must be one.
PBDSURG_HOST_DEVICE inline int nth_bit(std::uint64_t word, int rank) {
  // set bits of each byte, then of each byte and all below it
  std::uint64_t sums = word - ((word >> 1) & 0x5555555555555555u);
  sums = (sums & 0x3333333333333333u) + ((sums >> 2) & 0x3333333333333333u);
  sums = ((sums + (sums >> 4)) & 0x0F0F0F0F0F0F0F0Fu) * 0x0101010101010101u;
  int shift = 0;
  while (static_cast<int>((sums >> shift) & 0xFF) <= rank) {
    shift += 8;
  }
  if (shift > 0) {
    rank -= static_cast<int>((sums >> (shift - 8)) & 0xFF);
  }
  std::uint64_t byte = (word >> shift) & 0xFF;
  for (; rank > 0; --rank) {
    byte &= byte - 1;
  }
  return shift + lowest_bit(byte);
}

/// The lowest `count` bits, count in [0, 64].
PBDSURG_HOST_DEVICE inline std::uint64_t low_bits(int count) {
  return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

}  // namespace pbdsurg
