// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What changed of a body's surface, for who keeps one to draw.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/world/surface.h"

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// Fills all of a change but burns, and what is inner. Cost: O(vertices), and O(changed triangles).
/// @param vertex_count  that were seen
/// @param version       of the triangles that were seen
/// @param ranges        scratch
void collect_skin_changes(const pbdsurg::Surface& surface, std::size_t vertex_count,
                          std::uint64_t version, std::vector<pbdsurg::SlotRange>& ranges,
                          SurfaceChange& change);

}  // namespace cholecystectomy
