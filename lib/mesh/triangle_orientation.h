// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Consistent winding of triangle surfaces.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Turns triangles that are wound against their neighbours across edges of two triangles. In each
/// connected part the winding of the larger area stays.
/// @return  how many triangles were turned. Cost: O(n log n).
Index orient_triangles(std::span<const Eigen::Vector3d> points, std::span<Triangle> triangles);

}  // namespace pbdsurg
