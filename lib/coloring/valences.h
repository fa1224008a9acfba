// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many constraints there are at each vertex.

#include <vector>

#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// @param constraints  checked
/// @return [vertex_count]
[[nodiscard]] std::vector<Index> count_valences(const ConstraintVertices& constraints);

}  // namespace pbdsurg
