// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The constraints that hold the colours at each vertex.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Who has a colour at a vertex: looked up in a table where that has a reasonable size, otherwise
/// searched among the constraints there.
struct ColorHolders {
  Index* table = nullptr;          ///< [vertex_count * width] holds where the vertex has the colour
  Index width = 0;                 ///< colours
  const Index* offsets = nullptr;  ///< without a table: [vertex_count + 1] the constraints at each
  const Index* entries = nullptr;  ///< vertex, in any order

  /// Whether a table is of the size of the constraints themselves, give or take.
  static bool fits(Index vertex_count, Index colors, std::size_t entry_count) {
    constexpr std::int64_t kAlwaysFits = 1 << 24;
    constexpr std::int64_t kPerEntry = 16;
    return std::int64_t{vertex_count} * colors <=
           std::max(kAlwaysFits, kPerEntry * static_cast<std::int64_t>(entry_count));
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE Index& at(Index vertex, Index color) const {
    return table[static_cast<std::int64_t>(vertex) * width + color];
  }

  /// Reads the table where there is one, even if the vertex has not got the colour: looking at all
  /// vertices of a constraint at once is faster than one after another.
  [[nodiscard]] PBDSURG_HOST_DEVICE Index find(Index vertex, Index color, bool has_color,
                                               const Index* color_of) const {
    if (table != nullptr) {
      const Index holder = at(vertex, color);
      return has_color ? holder : kInvalidIndex;
    }
    if (!has_color) {
      return kInvalidIndex;
    }
    Index entry = offsets[vertex];
    while (color_of[entries[entry]] != color) {
      ++entry;
    }
    return entries[entry];
  }
};

}  // namespace pbdsurg
