// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What jaws meet as they close: points to grasp, of a mesh as coarse as it may be.

#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/grip.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// Points of a body's surface that jaws would meet: over a grid of places on the pad, the first on
/// the way of each jaw. Empty if jaws cannot hold them: if there are not three that are not on a
/// line. Cost: O(T log T) of the body's tetrahedra, and O(places) of each triangle between the
/// jaws.
/// @param pad      in the frame of the tool, where that is now
/// @param opening  m, positive: the jaws start half of it above and below the pad
/// @param spacing  m, positive: of places, at most
/// @throws InvalidArgument  naming the body, tool or copy that there is not, or the value out of
///                          range
[[nodiscard]] PBDSURG_API std::vector<TissuePoint> find_points_between(const Solver& solver,
                                                                       Index body, ToolId tool,
                                                                       const JawPad& pad,
                                                                       float opening, float spacing,
                                                                       Index copy = 0);

}  // namespace pbdsurg
