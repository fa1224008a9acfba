// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Lists of the features that tools may touch in the next substeps, so that not all of tissue is
/// gone through in each (Verlet 1967). A list has what is within a tool's reach and twice a slack;
/// it serves for as long as no vertex and no end of a capsule has moved by more than the slack. So
/// nothing that is met is ever left out, and contacts do not depend on when lists were made.

#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/near_features.h"

namespace pbdsurg {

/// Makes lists serve this substep, of tools that are placed. The slack is the largest radius of
/// those that meet surfaces.
/// Cost: O(vertices); where lists are made anew, O((vertices + triangles) * capsules).
void refresh_near_lists(const StepContext& step);

/// Those of a tool; null where it has to go through all: there is none, or it moves too fast.
[[nodiscard]] const NearFeatures* near_features(const StepContext& step, Index tool);

}  // namespace pbdsurg
