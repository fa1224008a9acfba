// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colourings of constraints: no two constraints of one colour share a vertex, so those of one
/// colour can be projected in any order, or at once, without atomics.

#include <optional>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// In place of a colour: the constraint is projected serially, after all colours. Only
/// limit_colors() puts constraints there.
inline constexpr Index kOverflowColor = kInvalidIndex;

/// A colour for each constraint.
struct Coloring {
  std::vector<Index> color_of;  ///< [constraint_count] in [0, color_count), or kOverflowColor
  Index color_count = 0;        ///< colours are [0, color_count)

  /// Whether each constraint has the same colour in both.
  friend bool operator==(const Coloring&, const Coloring&) = default;
};

/// Two constraints of one colour that share a vertex.
struct ColorConflict {
  Index color = kInvalidIndex;   ///< of both
  Index first = kInvalidIndex;   ///< constraint, the smaller of the two
  Index second = kInvalidIndex;  ///< constraint
  Index vertex = kInvalidIndex;  ///< shared by both
};

/// Checks a colouring.
/// @return the first conflict of the lowest colour that has one, or nothing if the colouring is
/// valid
/// @throws InvalidArgument  if there is not one colour in [0, color_count), or kOverflowColor, for
///                          each constraint; and as check_constraints()
[[nodiscard]] PBDSURG_API std::optional<ColorConflict> find_conflict(
    const Coloring& coloring, const ConstraintVertices& constraints);

/// [color_count] constraints of each colour.
/// @throws InvalidArgument  as find_conflict() for colours
[[nodiscard]] PBDSURG_API std::vector<Index> color_sizes(const Coloring& coloring);

/// How many colours there are and how evenly they are filled. Shares are of the coloured
/// constraints; the largest and the last tenth of the colours are counted in whole colours, rounded
/// up, as the figures in table 1 of Pan et al. 2020 imply; the only colour there is counts among
/// the largest.
struct ColoringStatistics {
  Index constraints = 0;          ///< overflow included
  Index colors = 0;               ///< Coloring::color_count
  Index clique_bound = 0;         ///< no colouring has fewer colours: clique_bound()
  Index overflow = 0;             ///< constraints in kOverflowColor
  double relative_deviation = 0;  ///< standard deviation of the colours' sizes / their mean
  double max_over_mean = 0;       ///< largest colour / mean
  double top10 = 0;               ///< share in the largest tenth of the colours
  double mid80 = 0;               ///< share in the colours between these tenths
  double last10 = 0;              ///< share in the smallest tenth of the colours
};

/// Counts colours and compares their sizes. Cost: O(vertices named).
/// @throws InvalidArgument  as find_conflict(), which it does not call
[[nodiscard]] PBDSURG_API ColoringStatistics
measure_coloring(const Coloring& coloring, const ConstraintVertices& constraints);

}  // namespace pbdsurg
