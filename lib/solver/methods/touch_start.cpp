// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_start.h"

#include <vector>

#include "lib/solver/methods/touch_search.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

TouchStart::TouchStart(const StepContext& step, const Substep<float>& lengths, StepReport& report)
    : step_(step),
      vertices_(moving_vertices(step)),
      starts_(vertices_.bases == nullptr ? step.scratch.previous.data() : vertices_.bases),
      ends_(moves_vertices(step.data.options) ? step.scratch.flights.data() : vertices_.moving),
      inverse_dt_squared_(lengths.inverse_dt_squared),
      report_(report) {
  for (const ContactPair& pair : step.data.contact_bodies.pairs()) {
    thickest_ = std::max(thickest_, pair.contact.thickness);
  }
}

bool TouchStart::is_within_reach(const TissueTouch& touch, float thickness, float distance) const {
  float mobility = 0, reach = kTouchReach * thickness;
  for (int side = 0; side < 2; ++side) {
    float ways = 0;
    for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
      ways = std::max(ways, way(touch.places[k]));
      mobility += step_.copy.particles[touch.places[k]].w;
    }
    reach += std::min(ways, kTouchWay * thickness);
  }
  return mobility > 0 && distance < reach && distance > -kDeepestTouch * thickness;
}

const RememberedTouch* TouchStart::find_remembered(const TouchSlot& slot) const {
  const std::vector<RememberedTouch>& all = step_.copy.touches.remembered;
  const auto found = std::ranges::lower_bound(all, slot, {}, &RememberedTouch::slot);
  return found != all.end() && found->slot == slot ? &*found : nullptr;
}

void TouchStart::add(TissueTouch touch, float distance, const TissueContact& settings,
                     const RememberedTouch* known) const {
  std::vector<TissueTouch>& contacts = step_.copy.touches.contacts;
  const SolverOptions& options = step_.data.options;
  if (contacts.size() >= static_cast<std::size_t>(options.contact_capacity)) {
    ++report_.dropped_contacts;
    return;
  }
  touch.mu = settings.friction;
  const float wanted = std::min(settings.thickness, distance + kRecovery * step_.data.part.h);
  touch.offset = vertices_.bases == nullptr ? wanted : wanted - distance;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    touch.drift = touch.drift + touch.weights[k] * own_start(step_, vertices_, touch.places[k]);
  }
  // projections begin anew
  if (known != nullptr && moves_vertices(options) && !is_explicit(options)) {
    const Vec3<float>& normal = touch.normal;
    touch.multiplier = known->force / inverse_dt_squared_;
    const Vec3<float> along = known->friction - dot(known->friction, normal) * normal;
    touch.friction = (1 / inverse_dt_squared_) * along;
  }
  contacts.push_back(touch);
}

}  // namespace pbdsurg
