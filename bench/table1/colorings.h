// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The ways to colour that table 1 compares.

#include <vector>

#include "pbdsurg/coloring/color.h"

namespace pbdsurg::bench {

/// "clique_bound", "conflicts"
[[nodiscard]] const char* name_of(Palette palette) noexcept;

/// All algorithms, plain; and the first and the last of them with repair and balance.
[[nodiscard]] std::vector<ColoringOptions> table1_colorings();

/// Colours on one thread.
/// @throws Error  if two constraints of one colour share a vertex
[[nodiscard]] Coloring color_validly(const ConstraintVertices& constraints,
                                     const ColoringOptions& options);

}  // namespace pbdsurg::bench
