// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_response.h"

#include <array>
#include <cmath>

#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/touch_search.h"
#include "lib/solver/methods/touched_pieces.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_yield.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

// m, sum(weights * u) of a side.
Vector side_of(const MovingVertices& vertices, const TissueTouch& touch, int side) {
  Vector sum;
  for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
    sum = sum + touch.weights[k] * load(vertices.moving[touch.places[k]]);
  }
  return sum;
}

void see(const MovingVertices& vertices, TissueTouch& touch) {
  for (int side = 0; side < 2; ++side) {
    touch.seen[side] = side_of(vertices, touch, side);
  }
}

// All corners, or none: momentum is theirs together.
void move(const StepContext& step, const MovingVertices& vertices, const TissueTouch& touch,
          const Vector& push) {
  std::array<Vector, TissueTouch::kCorners> ways;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    const Particle& p = vertices.moving[touch.places[k]];
    ways[k] = (touch.weights[k] * p.w) * push;
    if (!is_finite_way(load(p) + ways[k])) {
      return;
    }
  }
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    go_on(step, vertices, touch.places[k], ways[k]);
  }
}

// How often likely contacts push a corner. Those at a vertex, of which there may be many, are
// looked up once.
class LikelyPushes {
 public:
  explicit LikelyPushes(const StepContext& step) : step_(step), lists_(step.scratch.likely_pushes) {
    lists_.weights.clear();
    lists_.of_holds.assign(step.scratch.holds.size(), {});
  }

  // @param own  beside them
  [[nodiscard]] float sum(Index place, float own) {
    const auto [first, count] = list_at(place);
    for (Index i = first; i < first + count; ++i) {
      own += lists_.weights[static_cast<std::size_t>(i)];
    }
    return own;
  }

 private:
  [[nodiscard]] PushLists::Range list_at(Index place) {
    const Index first_hold = step_.scratch.first_holds[place];
    if (first_hold == kInvalidIndex) {
      return {0, 0};
    }
    PushLists::Range& range = lists_.of_holds[static_cast<std::size_t>(first_hold)];
    if (range.first == kInvalidIndex) {
      range = list(first_hold);
    }
    return range;
  }

  [[nodiscard]] PushLists::Range list(Index first_hold) {
    const auto first = static_cast<Index>(lists_.weights.size());
    for (Index h = first_hold; h != kInvalidIndex; h = step_.scratch.holds[h].next) {
      const VertexHold& hold = step_.scratch.holds[h];
      if (hold.kind == HoldKind::touch) {
        const TissueTouch& touch = step_.copy.touches.contacts[hold.entry];
        if (touch.is_likely) {
          lists_.weights.push_back(std::abs(touch.weights[hold.corner]));
        }
      }
    }
    return {first, static_cast<Index>(lists_.weights.size()) - first};
  }

  const StepContext& step_;
  PushLists& lists_;
};

// Moves corners by their masses.
void project(const StepContext& step, TissueTouch& touch, float friction) {
  const MovingVertices vertices = moving_vertices(step);
  float yield = 0;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    yield += touch.weights[k] * touch.weights[k] * vertices.moving[touch.places[k]].w;
  }
  project_contact(
      touch, friction, stiffness_of(yield), [&] { return read_touch(vertices, touch); },
      [&](const Vector& push) { move(step, vertices, touch, push); });
}

}  // namespace

ContactReading<float> read_touch(const MovingVertices& vertices, const TissueTouch& touch) {
  return read_plane(touch, side_of(vertices, touch, 0) + side_of(vertices, touch, 1));
}

void begin_touches(const StepContext& step, const VertexState& state) {
  if (!has_touches(step)) {
    return;
  }
  if (!has_custom(step)) {
    step.scratch.pushed.begin();
  }
  const MovingVertices vertices = moving_vertices(step);
  std::vector<TissueTouch>& touches = step.copy.touches.contacts;
  for (TissueTouch& touch : touches) {
    touch.is_likely = touch.multiplier > 0 || read_touch(vertices, touch).gap < 0;
  }
  LikelyPushes pushes(step);
  for (TissueTouch& touch : touches) {
    float yield = 0;
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      const Index place = touch.places[k];
      const float weight = std::abs(touch.weights[k]);
      yield += weight * pushes.sum(place, touch.is_likely ? 0 : weight) *
               yield_of(step, state, place, touch.normal);
    }
    touch.stiffness = yield > 0 ? 1 / yield : 0.0F;
  }
  see_touches(step);
}

void see_touches(const StepContext& step) {
  const MovingVertices vertices = moving_vertices(step);
  for (TissueTouch& touch : step.copy.touches.contacts) {
    see(vertices, touch);
  }
}

void add_touch(const StepContext& step, const TissueTouch& touch, int corner,
               float inverse_dt_squared, VertexEnergy<float>& energy) {
  const int side = touch.side_of(corner);
  const Vector sum = side_of(moving_vertices(step), touch, side) + touch.seen[1 - side];
  add_answer(touch,
             answer(touch, touch.mu, read_plane(touch, sum), inverse_dt_squared, touch.stiffness),
             touch.weights[corner], energy);
}

void project_touches(const StepContext& step) {
  for (TissueTouch& touch : step.copy.touches.contacts) {
    project(step, touch, touch.mu);
  }
}

void answer_touches(const StepContext& step, const Substep<float>& lengths) {
  if (!moves_vertices(step.data.options)) {
    project_touches(step);
    return;
  }
  balance_pieces(step, lengths);
  const MovingVertices vertices = moving_vertices(step);
  const float square = 1 / lengths.inverse_dt_squared;
  for (TissueTouch& touch : step.copy.touches.contacts) {
    see(vertices, touch);
    take_over(touch,
              answer(touch, touch.mu, read_plane(touch, touch.seen[0] + touch.seen[1]),
                     lengths.inverse_dt_squared, touch.stiffness)
                  .force,
              square);
  }
}

void settle_touches(const StepContext& step) {
  if (!has_touches(step)) {
    return;
  }
  step.scratch.meeting.begin_as(step.scratch.pushed);
  const MovingVertices vertices = moving_vertices(step);
  for (TissueTouch& touch : step.copy.touches.contacts) {
    if (read_touch(vertices, touch).gap < 0) {
      project(step, touch, 0);
    }
    if (touch.multiplier > 0) {
      step.scratch.meeting.join(touch.place_on(0), touch.place_on(1));
    }
  }
}

}  // namespace pbdsurg
