// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/proximity.h"

#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

#include "solver/solver_data.h"

namespace pbdsurg {

std::vector<Index> find_vertices_near(const Solver& solver, Index body,
                                      const Eigen::Vector3f& point, float radius) {
  static_cast<void>(solver.body(body));  // throws if there is none
  if (!point.allFinite() || !(radius > 0) || !std::isfinite(radius)) {
    throw InvalidArgument("a search radius is " + std::to_string(radius) +
                          " m; point and radius must be finite, the radius positive");
  }
  std::vector<Index> ids;
  for_each_vertex_of(solver_data(solver), body, [&](Index v) { ids.push_back(v); });
  std::vector<Eigen::Vector3f> positions(ids.size());
  solver.read_positions(ids, positions);
  std::vector<Index> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (solver.has_tissue(ids[i]) && (positions[i] - point).squaredNorm() < radius * radius) {
      found.push_back(ids[i]);
    }
  }
  return found;
}

}  // namespace pbdsurg
