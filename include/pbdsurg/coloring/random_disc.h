// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random colouring disc: all constraints draw colours at once and keep what does not clash.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// How a constraint's palette starts.
enum class Palette : std::uint8_t {
  /// All constraints draw from as many colours as the clique bound: few colours, evenly filled.
  clique_bound,
  /// 1 + floor(conflicts / shrink) colours, as in Vivace, where conflicts are the other constraints
  /// that share a vertex: low colours fill first, as in the paper's table 1.
  conflicts,
};

/// From how many colours constraints draw.
struct RandomDiscOptions {
  Palette palette = Palette::clique_bound;  ///< how it starts
  double shrink = 2;  ///< >= 1, of Palette::conflicts; refused with another palette, unless 2
};

/// Rounds of random draws (Grable, Panconesi 2000; Fratarcangeli, Tibaldo, Pellacini 2016,
/// "Vivace"): each uncoloured constraint draws one of the colours of its palette that its vertices
/// have not seen; of those that clash in a round the one with the largest random rank keeps its
/// draw; a constraint without a colour left gets the next one. The rank is what makes it end: when
/// all that clash give way, two neighbours with one colour left can do so forever.
///
/// The result depends on constraints, seed and options alone. Cost: 5 to 30 rounds (more for large
/// shrink), each over the constraints still uncoloured; palettes by conflicts look at the
/// neighbours of each constraint once; memory O(vertices * colours) bits and 4 bytes for each of up
/// to 32 colours a vertex.
/// @param seed     of draws and ranks
/// @param executor whose threads work, if it names how many
/// @throws InvalidArgument  as check_constraints(), or if an option is out of range
[[nodiscard]] PBDSURG_API Coloring color_random_disc(const ConstraintVertices& constraints,
                                                     std::uint64_t seed = 0,
                                                     const Executor& executor = {},
                                                     const RandomDiscOptions& options = {});

}  // namespace pbdsurg
