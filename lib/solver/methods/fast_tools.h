// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools that press on tissue and move fast for how thin they are: sweeps follow them in short
/// substeps alone. Within a substep their contacts are swept, so that nothing passes from where it
/// was met.

#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// Radii of a capsule that it may go in a substep.
inline constexpr float kFastWay = 0.5F;
/// How often as many substeps as without them a step takes at most.
inline constexpr int kMostForTools = 4;

/// Radii that a tool goes in a step, of those that met edges and triangles and pressed on tissue at
/// the end of the last one: by its targets, without what a spring leaves it behind. Places their
/// capsules.
[[nodiscard]] float farthest_way(CopyState& copy);

/// How many of them go too far in each of some substeps.
[[nodiscard]] Index count_fast_tools(CopyState& copy, int substeps);

}  // namespace pbdsurg
