// SPDX-License-Identifier: Apache-2.0
// What acts on a solver's vertices from outside: forces and gravity.
#include <algorithm>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/base/check.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

void Solver::set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces,
                        Index copy) {
  SolverData& data = *data_;
  CopyState& state = checked_copy(data, copy);
  check_forces(vertices, forces, data.particles.size());
  if (state.forces.empty()) {
    state.forces.reserve(state.particles.capacity());
    state.forces.resize(state.particles.size());
  }
  if (data.backend->keeps_state()) {
    std::vector<Changes::Force>& log = data.changes.forces;
    const std::size_t size = log.size() + vertices.size();
    log.reserve(size <= log.capacity() ? size : std::max(size, 2 * log.capacity()));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {  // nothing fails from here on
    const Index place = data.place_of_vertex[vertices[i]];
    state.forces[place] = {forces[i].x(), forces[i].y(), forces[i].z()};
    data.log_force(copy, place);
  }
}

void Solver::clear_forces(Index copy) {
  SolverData& data = *data_;
  CopyState& state = checked_copy(data, copy);
  for (std::size_t place = 0; place < state.forces.size(); ++place) {
    const Load& force = state.forces[place];
    if (force.x != 0 || force.y != 0 || force.z != 0) {
      data.log_force(copy, static_cast<Index>(place));
    }
  }
  state.forces.clear();
}

std::vector<Eigen::Vector3f> Solver::forces(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  std::vector<Eigen::Vector3f> out;
  for (std::size_t v = 0; v < state.forces.size(); ++v) {
    const Load& force = state.forces[data_->place_of_vertex[v]];
    out.emplace_back(force.x, force.y, force.z);
  }
  return out;
}

void Solver::set_gravity(const Eigen::Vector3f& gravity) {
  check_gravity(gravity);
  data_->gravity = gravity;
  data_->set_body_gravities(tissue(), {});
}

void Solver::set_gravity(Index body, const Eigen::Vector3f& gravity) {
  SolverData& data = *data_;
  const std::size_t count = tissue().bodies().size();
  check_id("body", body, count);
  check_gravity(gravity);
  std::vector<Eigen::Vector3f> own = data.body_gravities;
  own.resize(count, data.gravity);
  own[body] = gravity;
  data.set_body_gravities(tissue(), std::move(own));
}

Eigen::Vector3f Solver::gravity(Index body) const {
  check_id("body", body, tissue().bodies().size());
  return data_->gravity_of(body);
}

}  // namespace pbdsurg
