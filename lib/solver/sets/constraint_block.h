// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How constraints lie in memory: sixteen of one type side by side, so that a vector register takes
/// one number of each, and a number that a mode does not need is not fetched. This header and
/// particle.h are shared with kernels that are compiled for several instruction sets.

#include "pbdsurg/base/types.h"

#include "lib/solver/state/particle.h"

namespace pbdsurg {

inline constexpr Index kBlockLanes = 16;

template <class Constraint>
struct alignas(64) ConstraintBlock {
  ParticleOffset corners[Constraint::kVertexCount][kBlockLanes];
  float parameters[Constraint::kParameterCount][kBlockLanes];
};

template <class Constraint>
struct alignas(64) MultiplierBlock {
  float values[Constraint::kMultiplierCount][kBlockLanes];
};

}  // namespace pbdsurg
