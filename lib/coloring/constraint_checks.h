// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The part of check_constraints() that does not look at every vertex of the mesh.

#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// Refuses arrays that do not make constraints; ids are not read.
/// @throws InvalidArgument  naming the size or count that does not fit
void check_shape(const ConstraintVertices& constraints);

}  // namespace pbdsurg
