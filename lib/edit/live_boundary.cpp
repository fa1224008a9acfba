// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/live_boundary.h"

#include "solver/solver_data.h"

namespace pbdsurg {

std::vector<BoundaryTriangle> find_live_boundary(const Solver& solver, Index body) {
  static_cast<void>(solver.body(body));  // throws if there is none
  std::vector<Tet> live;
  std::vector<Index> ids;
  for_each_tet_of(solver_data(solver), body, [&](Index t) {
    if (solver.is_tet_alive(t)) {
      live.push_back(solver.tets()[t]);
      ids.push_back(t);
    }
  });
  std::vector<BoundaryTriangle> boundary = find_boundary(live);
  for (BoundaryTriangle& triangle : boundary) {
    triangle.tet = ids[triangle.tet];
  }
  return boundary;
}

}  // namespace pbdsurg
