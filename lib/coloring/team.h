// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the parallel colouring programs (*_program.h) ask of the team that runs them.
///
/// A program is one function that every worker of a team runs: CPU
/// threads (thread_team.h) or the threads of a CUDA grid. Workers form groups; a group owns a
/// contiguous part of the constraints. What programs use of a team:
///
///   group(), group_count()      who shares a part of the constraints
///   lane(), lane_count()        who this worker is within its group
///   worker(), worker_count()    who this worker is of all
///   barrier()                   all workers meet; what was written before is seen after
///   split(count, f, one, two)   calls f(i) for i in [0, count), shared out over the lanes of the
///                               group; it returns {place, index}: the index goes to the list `one`
///                               or `two`, or nowhere; returns to all lanes how many went where
///   raise(flag)                 sets a flag that others may be setting
///   peek(value)                 reads what others may be changing
///   fetch_max, fetch_or, ...    atomic where workers are concurrent
///
/// Between two barriers programs combine through maxima, sums and bit operations alone, so the
/// result does not depend on who comes first, nor on how many workers there are.

#include <cstdint>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Where Team::split() puts an index.
enum class Place : std::uint8_t { nowhere, one, two };
struct Sorted {
  Place place;
  Index index;
};
struct SplitCounts {
  Index one;
  Index two;
};

}  // namespace pbdsurg
