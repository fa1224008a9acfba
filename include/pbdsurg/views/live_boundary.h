// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The surface of what is left of a body.

#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// Boundary triangles of a body's live tetrahedra, in scene vertices and scene tetrahedra.
/// Found afresh: O(T log T) in the body's tetrahedra.
/// @throws InvalidArgument  if there is no such body
[[nodiscard]] PBDSURG_API std::vector<BoundaryTriangle> find_live_boundary(const Tissue& tissue,
                                                                           Index body);

}  // namespace pbdsurg
