// SPDX-License-Identifier: Apache-2.0
// Contact of a solver's bodies with each other.
#include <algorithm>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/solver_checks.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/told_contacts.h"

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
  return contacts_of_bodies(*data_, owner);
}

}  // namespace pbdsurg
