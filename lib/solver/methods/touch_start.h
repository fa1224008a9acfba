// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the searches for contacts between bodies have in common: where a substep starts, how far
/// vertices go in it, and how a contact begins.

#include <algorithm>
#include <cmath>
#include <span>

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/methods/touch_meeting.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_state.h"
#include "lib/solver/state/touch_lists.h"

namespace pbdsurg {

/// Of one copy: see touch_meeting.h.
class TouchStart {
 public:
  TouchStart(const StepContext& step, const Substep<float>& lengths, StepReport& report);

  /// m, of all pairs.
  [[nodiscard]] float thickest() const noexcept { return thickest_; }

  /// m
  [[nodiscard]] Vec3<float> position(Index place) const { return load(starts_[place]); }
  /// [place]
  [[nodiscard]] std::span<const Particle> positions() const noexcept {
    return {starts_, step_.copy.particles.size()};
  }

  /// m^2, of the way of a vertex in this substep, as nothing stops it.
  [[nodiscard]] float square_of_way(Index place) const {
    const Vec3<float> u =
        load(ends_[place]) - (vertices_.bases == nullptr ? position(place) : Vec3<float>{});
    return is_finite_way(u) ? dot(u, u) : 0;
  }
  /// m, likewise.
  [[nodiscard]] float way(Index place) const { return std::sqrt(square_of_way(place)); }
  /// m, likewise, to where sweeps begin.
  [[nodiscard]] Vec3<float> way_from_start(Index place) const {
    return load(vertices_.moving[place]) - own_start(place);
  }

  /// 1/kg
  [[nodiscard]] float mobility(Index place) const { return step_.copy.particles[place].w; }
  [[nodiscard]] Vec3<float> own_start(Index place) const {
    return pbdsurg::own_start(step_, vertices_, place);
  }
  [[nodiscard]] bool counts_from_origin() const noexcept { return vertices_.bases == nullptr; }

  /// Null where the last substep had none.
  [[nodiscard]] const RememberedTouch* find_remembered(const TouchSlot& slot) const;

  /// Adds a contact, if there is room for it: see begin_touch().
  /// @param known     what the last substep left; may be null
  void add(TissueTouch touch, float distance, const TissueContact& settings,
           const RememberedTouch* known) const;

 private:
  const StepContext& step_;
  MovingVertices vertices_;
  const Particle* starts_;
  const Particle* ends_;  // of its free way in this substep; displacements, where starts are bases
  float inverse_dt_squared_;
  StepReport& report_;
  float thickest_ = 0;
};

}  // namespace pbdsurg
