// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bits of a 64-bit word, on host and device.

#include <bit>
#include <cstdint>

#include "pbdsurg/base/host_device.h"

namespace pbdsurg {

/// How many bits are set.
PBDSURG_HOST_DEVICE inline int count_bits(std::uint64_t word) {
#if defined(__CUDA_ARCH__)
  return __popcll(static_cast<long long>(word));
#else
  // processors that lack the instruction would otherwise get a call
  word -= (word >> 1) & 0x5555555555555555u;
  word = (word & 0x3333333333333333u) + ((word >> 2) & 0x3333333333333333u);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  return static_cast<int>((word * 0x0101010101010101u) >> 56);
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
  // set bits of each pair, nibble, byte, 16 and 32 bits; then down the halves without a branch
  const std::uint64_t pairs = word - ((word >> 1) & 0x5555555555555555u);
  const std::uint64_t nibbles =
      (pairs & 0x3333333333333333u) + ((pairs >> 2) & 0x3333333333333333u);
  const std::uint64_t bytes = (nibbles + (nibbles >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  const std::uint64_t words = (bytes + (bytes >> 8)) & 0x00FF00FF00FF00FFu;
  const std::uint64_t halves = words + (words >> 16);
  int at = 0;
  const auto descend = [&](std::uint64_t sums, unsigned mask, int width) {
    const int below = static_cast<int>((sums >> at) & mask);
    const int up = rank >= below ? -1 : 0;
    rank -= below & up;
    at += width & up;
  };
  descend(halves, 0xFF, 32);
  descend(words, 0xFF, 16);
  descend(bytes, 0xF, 8);
  descend(nibbles, 0x7, 4);
  descend(pairs, 0x3, 2);
  descend(word, 0x1, 1);
  return at;
}

/// The lowest `count` bits, count in [0, 64].
PBDSURG_HOST_DEVICE inline std::uint64_t low_bits(int count) {
  return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

}  // namespace pbdsurg
