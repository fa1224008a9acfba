// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// First fit in a random order, which a parallel machine can follow.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Each constraint draws one key; it is coloured, with the lowest colour that is free, once all
/// constraints of larger key that share a vertex with it are (Jones, Plassmann 1993, "A parallel
/// graph coloring heuristic"). That is first fit in the order of the keys, and on a CPU it is
/// computed as such, by one thread.
///
/// The result depends on constraints and seed alone. Cost: O(vertices named), without locality.
/// @throws InvalidArgument  as check_constraints()
[[nodiscard]] PBDSURG_API Coloring color_jones_plassmann(const ConstraintVertices& constraints,
                                                         std::uint64_t seed = 0);

}  // namespace pbdsurg
