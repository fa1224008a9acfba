// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/proximity.h"

#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {

std::vector<Index> find_vertices_near(const Solver& solver, Index body,
                                      const Eigen::Vector3f& point, float radius) {
  const std::vector<Index> ids = solver.tissue().vertices_of(body);
  if (!point.allFinite() || !(radius > 0) || !std::isfinite(radius)) {
    throw InvalidArgument("a search radius is " + std::to_string(radius) +
                          " m; point and radius must be finite, the radius positive");
  }
  std::vector<Eigen::Vector3f> positions(ids.size());
  solver.read_positions(ids, positions);
  std::vector<Index> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (solver.tissue().has_tissue(ids[i]) &&
        (positions[i] - point).squaredNorm() < radius * radius) {
      found.push_back(ids[i]);
    }
  }
  return found;
}

}  // namespace pbdsurg
