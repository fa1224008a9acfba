// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What lies near a point: the vertices that a jaw closes on.

#include <Eigen/Core>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// Scene vertices of a body, with tissue, within a distance of a point, ascending.
/// Cost: O(vertices of the body).
/// @param point   m
/// @param radius  m, positive and finite
/// @throws InvalidArgument  if there is no such body, or the point or radius is out of range
[[nodiscard]] PBDSURG_API std::vector<Index> find_vertices_near(const Solver& solver, Index body,
                                                                const Eigen::Vector3f& point,
                                                                float radius);

}  // namespace pbdsurg
