// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The colours at each vertex, as rows of bits.

#include <cstdint>

#include "pbdsurg/base/bits.h"
#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

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

/// Colours to choose from, drawn evenly.
/// @tparam FreeWord  free_word(i): colours [64 i, 64 i + 64) to choose from, for i in [0, words)
template <class FreeWord>
class ColorDraw {
 public:
  PBDSURG_HOST_DEVICE ColorDraw(int words, const FreeWord& free_word)
      : free_word_(free_word), first_(free_word(0)), count_(count_bits(first_)) {
    for (int i = 1; i < words; ++i) {
      count_ += count_bits(free_word(i));
    }
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool empty() const { return count_ == 0; }

  /// @param random  of which the upper half is used
  [[nodiscard]] PBDSURG_HOST_DEVICE Index draw(std::uint64_t random) const {
    auto rank = static_cast<int>(((random >> 32) * static_cast<std::uint64_t>(count_)) >> 32);
    std::uint64_t word = first_;
    for (int i = 0;;) {
      const int here = count_bits(word);
      if (rank < here) {
        return 64 * i + nth_bit(word, rank);
      }
      rank -= here;
      word = free_word_(++i);
    }
  }

 private:
  FreeWord free_word_;
  std::uint64_t first_;
  int count_;
};

/// One of the colours, or kInvalidIndex if there is none.
template <class FreeWord>
PBDSURG_HOST_DEVICE Index draw_color(int words, const FreeWord& free_word, std::uint64_t random) {
  const ColorDraw<FreeWord> colors(words, free_word);
  return colors.empty() ? kInvalidIndex : colors.draw(random);
}

}  // namespace pbdsurg
