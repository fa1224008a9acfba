// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/live_boundary.h"

namespace pbdsurg {

std::vector<BoundaryTriangle> find_live_boundary(const Tissue& tissue, Index body) {
  std::vector<Tet> live;
  std::vector<Index> ids;
  for (const Index t : tissue.tets_of(body)) {
    if (tissue.is_tet_alive(t)) {
      live.push_back(tissue.tets()[t]);
      ids.push_back(t);
    }
  }
  std::vector<BoundaryTriangle> boundary = find_boundary(live);
  for (BoundaryTriangle& triangle : boundary) {
    triangle.tet = ids[triangle.tet];
  }
  return boundary;
}

}  // namespace pbdsurg
