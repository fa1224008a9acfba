// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/live_boundary.h"

namespace pbdsurg {

std::vector<BoundaryTriangle> find_live_boundary(const Solver& solver, Index body) {
  const Body& where = solver.body(body);
  std::vector<Tet> live;
  std::vector<Index> ids;
  const auto add = [&](Index t) {
    if (solver.is_tet_alive(t) && solver.body_of_tet(t) == body) {
      live.push_back(solver.tets()[t]);
      ids.push_back(t);
    }
  };
  for (Index t = where.first_tet; t < where.first_tet + where.tet_count; ++t) {
    add(t);
  }
  const Body& last = solver.bodies().back();
  for (Index t = last.first_tet + last.tet_count; t < static_cast<Index>(solver.tets().size());
       ++t) {
    add(t);
  }
  std::vector<BoundaryTriangle> boundary = find_boundary(live);
  for (BoundaryTriangle& triangle : boundary) {
    triangle.tet = ids[triangle.tet];
  }
  return boundary;
}

}  // namespace pbdsurg
