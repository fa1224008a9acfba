// SPDX-License-Identifier: Apache-2.0
// Contact of a solver's bodies with each other.
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

void Solver::set_body_contact(Index first, Index second, const TissueContact& contact) {
  check_contact_pair({first, second, contact}, *data_);
  data_->finish_running_step();
  data_->surface.begin(tissue());
  data_->contact_bodies.set({std::min(first, second), std::max(first, second), contact});
  data_->reserve_touches();
  data_->rebuild_plan();
}

void Solver::clear_body_contact(Index first, Index second) {
  static_cast<void>(tissue().body(first));
  static_cast<void>(tissue().body(second));
  data_->finish_running_step();
  data_->contact_bodies.remove(std::min(first, second), std::max(first, second));
  for (Index i = 0; i < data_->copy_count(); ++i) {
    TissueTouches& touches = data_->copy(i).touches;
    if (data_->contact_bodies.empty()) {
      touches = {};
    }
  }
  data_->rebuild_plan();
}

std::vector<BodyContact> Solver::body_contacts(Index copy) const {
  const CopyState& owner = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  const TissueTouches& touches = owner.touches;
  const float scale = owner.factors.stiffness;  // see substep_numbers()
  std::vector<BodyContact> contacts;
  if (touches.contacts.empty()) {
    return contacts;
  }
  const std::vector<Index> vertex_at = data_->vertices_at_places();
  for (std::size_t c = 0; c < touches.contacts.size(); ++c) {
    const TissueTouch& touch = touches.contacts[c];
    const RememberedTouch& force = touches.remembered[c];
    BodyContact& told = contacts.emplace_back();
    told.first = touch.bodies[0];
    told.second = touch.bodies[1];
    told.first_count = touch.first_corners;
    std::array<Eigen::Vector3f, 2> points{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      const bool is_again = k == 3 && touch.places[k] == touch.places[k - 1];
      const int side = touch.side_of(k);
      told.vertices[k] = is_again ? kInvalidIndex : vertex_at[touch.places[k]];
      told.weights[k] = side == 0 ? touch.weights[k] : -touch.weights[k];
      points[side] += told.weights[k] * vector_of(load(owner.particles[touch.places[k]]));
    }
    told.point = points[1];
    told.normal = vector_of(touch.normal);
    told.distance = told.normal.dot(points[0] - points[1]);
    told.force = scale * vector_of(force.force * force.normal + force.friction);
  }
  return contacts;
}

}  // namespace pbdsurg
