// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/proximity.h"

#include <cmath>
#include <numeric>
#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {

std::vector<Index> find_vertices_near(const Solver& solver, Index body,
                                      const Eigen::Vector3f& point, float radius) {
  const Body& where = solver.body(body);
  if (!point.allFinite() || !(radius > 0) || !std::isfinite(radius)) {
    throw InvalidArgument("a search radius is " + std::to_string(radius) +
                          " m; point and radius must be finite, the radius positive");
  }
  std::vector<Index> ids(static_cast<std::size_t>(where.vertex_count));
  std::iota(ids.begin(), ids.end(), where.first_vertex);
  const Body& last = solver.bodies().back();
  for (Index v = last.first_vertex + last.vertex_count; v < solver.vertex_count(); ++v) {
    if (solver.body_of_vertex(v) == body) {  // edits brought it
      ids.push_back(v);
    }
  }
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
