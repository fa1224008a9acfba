// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/eased_pieces.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/moving_piece.h"
#include "lib/solver/methods/piece_easing.h"
#include "lib/solver/methods/touched_pieces.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Calls add(sum, place, mass) for all vertices of a piece that count, and adds up the sums.
template <class Sums, class Add>
Sums sum_over(const StepContext& step, const MovingPiece& piece, const Add& add) {
  std::array<Sums, kMomentumSums> sums;
  std::size_t i = 0;
  piece.for_each_place([&](Index place) {
    Sums& sum = sums[i++ % kMomentumSums];
    if (piece.counts(place)) {
      add(sum, place, 1 / static_cast<double>(step.copy.particles[place].w));
    }
  });
  return total(sums);
}

// A piece and the motion that pushes give it.
class EasedPiece {
 public:
  EasedPiece(const StepContext& step, const TouchedPiece& touched)
      : step_(step), piece_(step, touched.piece, groups_of(step)) {
    const auto add = [&](MomentumSums& sums, Index place, double mass) {
      sums.add(mass, position(place), {0, 0, 0});
    };
    pushes_.sums = sum_over<MomentumSums>(step, piece_, add);
  }

  [[nodiscard]] const MovingPiece& piece() const { return piece_; }
  [[nodiscard]] const Pushes& pushes() const { return pushes_; }

  void add(const SurfaceContact& contact) {
    pushes_.add(contact.multiplier, contact.normal,
                arm_at(contact, [&](Index place) { return position(place); }));
  }
  // At one point for both sides, so that together they get no spin.
  void add(const TissueTouch& touch, int side) {
    pushes_.add(touch.multiplier, side == 0 ? touch.normal : -1.0F * touch.normal,
                arm_at(touch, 1, [&](Index place) { return position(place); }));
  }

  // Once all pushes are added.
  [[nodiscard]] EasingSums sums() {
    motion_ = pushes_.sums.rigid_move();
    const CopyState& copy = step_.copy;
    const auto add = [&](EasingSums& sums, Index place, double mass) {
      const Vec3<double> along = to_double(part_of(motion_, position(place)));
      sums.add(mass, along, load(copy.velocities[place]), load(copy.ways[place]),
               load(copy.velocities_before[place]), step_.data.part.h);
    };
    return sum_over<EasingSums>(step_, piece_, add);
  }

  void ease(const Easing& easing) const {
    piece_.for_each_place([&](Index place) {
      if (piece_.counts(place)) {
        const Vec3<float> along = part_of(motion_, position(place));
        speed_up(step_.copy.velocities[place], static_cast<float>(easing.now) * along);
        speed_up(step_.copy.velocities_before[place], static_cast<float>(easing.before) * along);
      }
    });
  }

 private:
  [[nodiscard]] Vec3<double> position(Index place) const {
    return to_double(load(step_.copy.particles[place]));
  }

  const StepContext& step_;
  MovingPiece piece_;
  Pushes pushes_;
  RigidMove motion_{};
};

// Of tools and of what has no such motion.
void ease_alone(const StepContext& step, const TouchedPiece& touched) {
  EasedPiece eased(step, touched);
  const auto for_each = [&](const auto& visit_surface, const auto& visit_touch) {
    for_each_contact(step, eased.piece(), visit_surface, [&](TissueTouch& touch, int side) {
      if (find_touched(step, touch.place_on(1 - side)) == kInvalidIndex) {
        visit_touch(touch, side);
      }
    });
  };
  for_each([&](const SurfaceContact& contact, const ToolState& /*tool*/) { eased.add(contact); },
           [&](const TissueTouch& touch, int side) { eased.add(touch, side); });
  const Easing easing = eased.sums().easing(eased.pushes());
  eased.ease(easing);
  // in substeps of one length these velocities count so much for all that are to come
  const StepPart& part = step.data.part;
  const float relief = relief_of(easing, part.h, part.per_step, step.copy.factors.density);
  for_each(
      [&](SurfaceContact& contact, ToolState& /*tool*/) {
        contact.is_eased = true;
        contact.relief = relief;
      },
      [](TissueTouch& touch, int /*side*/) { touch.is_eased = true; });
}

// Of each other. What both have in common of mass stands for that of one.
void ease_pair(const StepContext& step, Index first, Index second) {
  EasedPiece one(step, step.scratch.touched[first]), other(step, step.scratch.touched[second]);
  const auto add = [&](TissueTouch& touch, int side) {
    if (find_touched(step, touch.place_on(1 - side)) == second) {
      one.add(touch, side);
      other.add(touch, 1 - side);
      touch.is_eased = true;
    }
  };
  for_each_contact(
      step, one.piece(), [](const SurfaceContact&, const ToolState&) {}, add);
  EasingSums sums = one.sums();
  sums.add(other.sums());
  const Easing easing = sums.easing(between(one.pushes(), other.pushes()));
  one.ease(easing);
  other.ease(easing);
}

void ease_pairs(const StepContext& step) {
  std::vector<PiecePair>& pairs = step.scratch.piece_pairs;
  pairs.clear();
  for (const TissueTouch& touch : step.copy.touches.contacts) {
    const Index a = find_touched(step, touch.place_on(0)),
                b = find_touched(step, touch.place_on(1));
    if (touch.multiplier > 0 && a != kInvalidIndex && b != kInvalidIndex && a != b) {
      pairs.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  for (const auto& [first, second] : pairs) {
    ease_pair(step, first, second);
  }
}

}  // namespace

void ease_pieces(const StepContext& step) {
  list_touched_pieces(step);
  for (Index i = 0; i < step.scratch.touched.count(); ++i) {
    ease_alone(step, step.scratch.touched[i]);
  }
  ease_pairs(step);
  for (ToolState& tool : step.copy.tools) {
    for (const SurfaceContact& contact : tool.surface_contacts) {
      if (contact.is_eased) {
        feel_contact(contact, contact.multiplier * contact.normal, contact.relief, tool);
      }
    }
  }
}

}  // namespace pbdsurg
