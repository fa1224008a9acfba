// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The colours at each vertex, as rows of bits.

#include <cstdint>

#include "pbdsurg/core/bits.h"
#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/types.h"

namespace pbdsurg {

struct ColorMasks {
  std::uint64_t* bits = nullptr;  ///< [vertex_count * words]
  int words = 1;                  ///< 64 colours each

  [[nodiscard]] PBDSURG_HOST_DEVICE std::uint64_t& word(Index vertex, int index) const {
    return bits[static_cast<std::uint64_t>(vertex) * words + index];
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE bool has(Index vertex, Index color) const {
    return ((word(vertex, color >> 6) >> (color & 63)) & 1) != 0;
  }

  /// Colours [64 index, 64 index + 64) that none of the vertices has, below `limit`.
  template <class Ids>
  [[nodiscard]] PBDSURG_HOST_DEVICE std::uint64_t free_word(const Ids& ids, int index,
                                                            Index limit) const {
    std::uint64_t used = 0;
    for (const Index v : ids) {
      used |= word(v, index);
    }
    return limit <= 64 * index ? 0 : ~used & low_bits(limit - 64 * index);
  }
};

/// One of several colours, evenly; kInvalidIndex if there is none.
/// @param free_word  free_word(i): colours [64 i, 64 i + 64) to choose from, for i in [0, words)
/// @param draw       random bits, of which the upper half is used
template <class FreeWord>
PBDSURG_HOST_DEVICE Index draw_color(int words, const FreeWord& free_word, std::uint64_t draw) {
  draw >>= 32;
  if (words == 1) {
    const std::uint64_t word = free_word(0);
    const auto count = static_cast<std::uint64_t>(count_bits(word));
    return count == 0 ? kInvalidIndex : nth_bit(word, static_cast<int>((draw * count) >> 32));
  }
  std::uint64_t count = 0;
  for (int i = 0; i < words; ++i) {
    count += static_cast<std::uint64_t>(count_bits(free_word(i)));
  }
  auto rank = static_cast<int>((draw * count) >> 32);
  for (int i = 0; i < words && count > 0; ++i) {
    const std::uint64_t word = free_word(i);
    const int here = count_bits(word);
    if (rank < here) {
      return 64 * i + nth_bit(word, rank);
    }
    rank -= here;
  }
  return kInvalidIndex;
}

}  // namespace pbdsurg
