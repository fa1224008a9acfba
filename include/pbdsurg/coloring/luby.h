// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colouring by maximal independent sets.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// For each colour in turn, a maximal set of uncoloured constraints that share no vertex, found by
/// rounds of random keys (Luby 1986, "A simple parallel algorithm for the maximal independent set
/// problem"): a constraint joins when its key is the largest at each of its vertices.
///
/// The result depends on constraints and seed alone. Cost: O(log n) rounds a colour, each over the
/// constraints that may still join.
/// @param seed     of the keys
/// @param executor whose threads work, if it names how many
/// @throws InvalidArgument  as check_constraints()
[[nodiscard]] PBDSURG_API Coloring color_luby(const ConstraintVertices& constraints,
                                              std::uint64_t seed = 0,
                                              const Executor& executor = {});

}  // namespace pbdsurg
