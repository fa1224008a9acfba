// SPDX-License-Identifier: Apache-2.0
#include "solver/backend.h"

#include "solver/solver_data.h"

namespace pbdsurg {

void Backend::fetch_state(SolverData& /*data*/) {}

void Backend::read_positions(const SolverData& data, std::span<const Index> places,
                             std::span<Eigen::Vector3f> out) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Particle& p = data.particles[places[i]];
    out[i] = {p.x, p.y, p.z};
  }
}

}  // namespace pbdsurg
