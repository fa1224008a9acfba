// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colours of equal size.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Moves constraints from colours above the mean size to free ones below it, without an extra
/// colour. A guided shuffle (Lu et al. 2017, "Algorithms for balanced graph colorings"), in sweeps:
/// constraints of a colour volunteer with the probability that would bring it to the mean, and draw
/// a free colour below the mean. While many volunteer, the colours take turns, as those of one
/// colour cannot clash; when few are left, all move at once, but for those whose neighbour of
/// larger random rank drew the same.
///
/// The colouring stays valid; a colour that loses all of its few constraints is closed. It ends
/// when the largest colour and the deviation are within 1/64 of the mean, or after 32 sweeps.
///
/// Where the sizes then deviate from whole numbers around their mean by more than 2 %, as with few
/// colours or on a lattice, the colouring that was given is balanced once more, from the beginning
/// and by one thread: along the order of the constraints, those above the mean move to a colour
/// below it by short Kempe chains (two colours exchanged among constraints that hang together). The
/// more even of the two results stays.
///
/// The result depends on the arguments other than the executor alone. Cost: each sweep looks at the
/// colour of every constraint, and at the vertices of those that move; memory 1 bit a vertex and
/// colour, 32 bytes a vertex and 12 a constraint. Chains take about as long as the sweeps, or up to
/// four times that among 28 colours of a lattice, and memory as repair_coloring() does.
/// @param coloring  valid; overflow stays where it is
/// @param executor  whose threads work, if it names how many
/// @throws InvalidArgument  as find_conflict() and check_constraints(), if the colouring is not
///                          valid; then nothing has changed
PBDSURG_API void balance_coloring(Coloring& coloring, const ConstraintVertices& constraints,
                                  std::uint64_t seed = 0, const Executor& executor = {});

}  // namespace pbdsurg
