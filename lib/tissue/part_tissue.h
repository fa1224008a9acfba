// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissue that parts along faces, and sheets along edges: corners of tetrahedra and triangles and
/// ends of links move to copies of vertices.

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Moves corners, and gives tetrahedra edges of their own where they no longer share them.
/// Cost: proportional to the tetrahedra around edges at corners that move.
void move_corners(TissueData& data, const TopologyEdit& edit);

void move_triangles(TissueData& data, const TopologyEdit& edit);

void move_links(TissueData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
