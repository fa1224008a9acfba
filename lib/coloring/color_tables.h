// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a program that changes a colouring starts from.

#include <cstdint>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

#include "lib/coloring/color_holders.h"

namespace pbdsurg {

struct ColorTables {
  int words = 1;                     ///< 64 colours each
  std::vector<std::uint64_t> masks;  ///< [vertex_count * words] as ColorMasks
  std::vector<Index> sizes;          ///< [color_count]
};

/// @throws InvalidArgument  as check_constraints() and find_conflict(), or naming the first
/// conflict
[[nodiscard]] ColorTables make_color_tables(const Coloring& coloring,
                                            const ConstraintVertices& constraints);

/// The memory behind the ColorHolders of a valid colouring.
class HolderTable {
 public:
  HolderTable(const Coloring& coloring, const ConstraintVertices& constraints);
  [[nodiscard]] ColorHolders view();

 private:
  Index width_;
  std::vector<Index> table_;  // or else
  IndexLists lists_;
};

/// Constraints of colours from `first` on.
[[nodiscard]] PBDSURG_API Index count_from(const std::vector<Index>& sizes, Index first);

/// [color_count] a new number for each colour: the largest is 0, of equal ones the lower first.
[[nodiscard]] PBDSURG_API std::vector<Index> numbers_by_size(const std::vector<Index>& sizes);

}  // namespace pbdsurg
