// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The outside of a body without its cavities.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// Boundary shells that enclose the body; those around a cavity, which enclose a negative volume,
/// are left out. Points are compacted, in their order.
[[nodiscard]] MeshData outer_surface(std::span<const Eigen::Vector3d> positions,
                                     std::span<const Tet> tets);

}  // namespace pbdsurg
