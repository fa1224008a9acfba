// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_start.h"

#include <vector>

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
    ++report_.dropped_contacts.of_bodies;
    return;
  }
  const bool goes_on = moves_vertices(options) && !is_explicit(options);  // projections begin anew
  begin_touch(*this, distance, settings.thickness, settings.friction, step_.data.part.h,
              inverse_dt_squared_, goes_on ? known : nullptr, touch);
  contacts.push_back(touch);
}

}  // namespace pbdsurg
