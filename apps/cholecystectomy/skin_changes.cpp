// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/skin_changes.h"

#include <algorithm>

namespace cholecystectomy {

void collect_skin_changes(const pbdsurg::Surface& surface, std::size_t vertex_count,
                          std::uint64_t version, std::vector<pbdsurg::SlotRange>& ranges,
                          SurfaceChange& change) {
  change.positions.assign(surface.positions().begin(), surface.positions().end());
  const auto rest = surface.rest_positions();
  const auto come = rest.subspan(std::min(vertex_count, rest.size()));
  change.new_rest_positions.assign(come.begin(), come.end());
  surface.collect_changes(version, ranges);
  change.triangles.resize(ranges.size());
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    const auto first = static_cast<std::size_t>(ranges[r].first);
    const auto values =
        surface.triangles().subspan(first, static_cast<std::size_t>(ranges[r].end) - first);
    change.triangles[r].first = ranges[r].first;
    change.triangles[r].values.assign(values.begin(), values.end());
  }
}

}  // namespace cholecystectomy
