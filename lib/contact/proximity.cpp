// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/proximity.h"

#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

#include "solver/solver_data.h"

namespace pbdsurg {

std::vector<Index> find_vertices_near(const Solver& solver, Index body,
                                      const Eigen::Vector3f& point, float radius) {
  const SolverData& data = solver_data(solver);
  if (body < 0 || body >= static_cast<Index>(data.bodies.size())) {
    throw InvalidArgument("there is no body " + std::to_string(body) + "; the solver has " +
                          std::to_string(data.bodies.size()));
  }
  if (!point.allFinite() || !(radius > 0) || !std::isfinite(radius)) {
    throw InvalidArgument("a search radius is " + std::to_string(radius) +
                          " m; point and radius must be finite, the radius positive");
  }
  const Body& where = data.bodies[body];
  std::vector<Index> found;
  for (Index v = where.first_vertex; v < where.first_vertex + where.vertex_count; ++v) {
    const Particle& p = data.particles[v];
    if (data.vertex_masses[v] > 0 &&
        (Eigen::Vector3f(p.x, p.y, p.z) - point).squaredNorm() < radius * radius) {
      found.push_back(v);
    }
  }
  return found;
}

}  // namespace pbdsurg
