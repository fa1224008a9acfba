// SPDX-License-Identifier: Apache-2.0
// What acts on a solver's vertices from outside: forces and gravity.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/base/check.h"
#include "lib/base/describe.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

void check_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces,
                  std::size_t vertex_count) {
  if (vertices.size() != forces.size()) {
    throw InvalidArgument("there are " + std::to_string(forces.size()) + " forces for " +
                          std::to_string(vertices.size()) + " vertices; one each");
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    check_id("vertex", vertices[i], vertex_count);
    if (!forces[i].allFinite()) {
      throw InvalidArgument("the force at vertex " + std::to_string(vertices[i]) + " is " +
                            describe(Eigen::Vector3d(forces[i].cast<double>())) +
                            " N; it must be finite");
    }
  }
  std::vector<Index> sorted(vertices.begin(), vertices.end());
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
    throw InvalidArgument("vertex " + std::to_string(*twice) +
                          " is named twice; a vertex has one force");
  }
}

}  // namespace

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
    data.changes.forces.reserve(data.changes.forces.size() + vertices.size());
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
