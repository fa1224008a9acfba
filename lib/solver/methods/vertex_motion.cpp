// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_motion.h"

#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

bool has_displacements(const SolverOptions& options) noexcept {
  return options.mode == ProjectionMode::compliance;
}

FreeMotion<float> free_motion(const SolverData& data, const CopyState& copy, float h) noexcept {
  const float factor = copy.factors.gravity;
  const Vec3<float> gravity = factor * load(data.gravity);
  const float square = dot(gravity, gravity);
  return {h,
          1 / h,
          1 / (1 + data.options.damping * h),
          h * gravity,
          (h * h) * gravity,
          (square > 0 ? 1 / square : 0.0F) * gravity,
          factor * h,
          factor * (h * h),
          factor != 0 ? 1 / factor : 0,
          h / copy.factors.density};
}

FreeMotion<float> falling_motion(const SolverData& data, const FreeMotion<float>& motion,
                                 Index place) noexcept {
  if (data.gravities.empty()) {
    return motion;
  }
  const Load& gravity = data.gravities[place];
  return under(load(gravity), gravity.inverse_square, motion);
}

FreeMotion<float> flying_motion(const CopyState& copy, const FreeMotion<float>& falling,
                                Index place) noexcept {
  return copy.forces.empty()
             ? falling
             : pushed_by(load(copy.forces[place]), copy.particles[place].w, falling);
}

namespace {

// Calls visit(v, falling, flying) with the motions of each vertex, as the two above say.
template <class Visit>
void for_each_motion(const StepContext& step, const FreeMotion<float>& motion, const Visit& visit) {
  const std::size_t count = step.copy.particles.size();
  if (step.copy.forces.empty() && step.data.gravities.empty()) {
    for (std::size_t v = 0; v < count; ++v) {
      visit(v, motion, motion);
    }
    return;
  }
  for (std::size_t v = 0; v < count; ++v) {
    const auto place = static_cast<Index>(v);
    const FreeMotion<float> falling = falling_motion(step.data, motion, place);
    visit(v, falling, flying_motion(step.copy, falling, place));
  }
}

}  // namespace

bool has_past(const SolverOptions& options) noexcept {
  return options.integration == TimeIntegration::bdf2;
}

bool has_past_lengths(const SolverOptions& options) noexcept {
  return has_past(options) || is_explicit(options);
}

SubstepNumbers substep_numbers(const SolverData& data, const CopyState& copy, float h,
                               int substep) noexcept {
  // Elastic forces and masses are those of the scene: that much of the scene's inertia has the
  // copy's effect. So all forces of a substep are those of the copy over its stiffness.
  const float inertia = copy.factors.density / copy.factors.stiffness;
  if (!has_past_lengths(data.options)) {
    return {free_motion(data, copy, h), {1 / h, inertia / (h * h)}};
  }
  const float before = data.part.past_h > 0 ? data.part.past_h : copy.past_substep;
  const float past = substep > 0 ? h : before;
  if (is_explicit(data.options)) {
    const float between = (past + h) / 2;  // velocities
    SubstepNumbers numbers{free_motion(data, copy, between), {1 / h, 1 / (h * between)}};
    numbers.motion.h = h;
    numbers.motion.inverse_h = 1 / h;
    numbers.motion.fall = h * numbers.motion.kick;
    numbers.motion.fall_square = h * numbers.motion.kick_time;
    return numbers;
  }
  const float ratio = past > 0 ? h / past : 0;
  const float part = (1 + ratio) / (1 + 2 * ratio) * h;
  const float drag = 1 + data.options.damping * part;
  SubstepNumbers numbers{free_motion(data, copy, part), {1 / part, inertia * drag / (part * part)}};
  // drag of second order acts on all that moves a vertex: like more inertia
  numbers.motion.kick = numbers.motion.keep * numbers.motion.kick;
  numbers.motion.fall = numbers.motion.keep * numbers.motion.fall;
  numbers.motion.kick_time = numbers.motion.keep * numbers.motion.kick_time;
  numbers.motion.fall_square = numbers.motion.keep * numbers.motion.fall_square;
  numbers.motion.push_time = numbers.motion.keep * numbers.motion.push_time;
  numbers.past_share = ratio * ratio / (1 + 2 * ratio);
  return numbers;
}

MovingVertices moving_vertices(const StepContext& step) noexcept {
  if (has_displacements(step.data.options)) {
    const bool has_points = moves_vertices(step.data.options);
    return {step.scratch.displacements.data(), step.copy.particles.data(),
            has_points ? step.scratch.fixed_points.data() : nullptr};
  }
  return {step.copy.particles.data(), nullptr};
}

Vec3<float> own_start(const StepContext& step, const MovingVertices& vertices,
                      Index place) noexcept {
  if (vertices.bases == nullptr) {
    return load(step.scratch.previous[place]);
  }
  return has_past(step.data.options) ? load(step.copy.ways[place])  // see recall_past()
                                     : load(step.copy.carries[place]);
}

void go_on(const StepContext& step, const MovingVertices& vertices, Index place,
           const Vec3<float>& way) {
  Particle& p = vertices.moving[place];
  const Vec3<float> before = load(p), after = before + way;
  if (!is_finite_way(after)) {
    return;
  }
  store(p, after);
  if (vertices.points != nullptr && !is_explicit(step.data.options)) {
    FixedPoint& point = vertices.points[place];
    point = moved_point(point, before, after);
  }
}

void predict_positions(const StepContext& step, const FreeMotion<float>& motion) {
  const auto predict = [&](std::size_t v, const auto&, const FreeMotion<float>& flying) {
    Particle& p = step.copy.particles[v];
    step.scratch.previous[v] = p;
    if (p.w > 0) {
      store(p, load(p) + flying.h * (flying.keep * load(step.copy.velocities[v]) + flying.kick));
    }
  };
  for_each_motion(step, motion, predict);
}

void update_velocities(const StepContext& step, const FreeMotion<float>& motion) {
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    const Vec3<float> way = load(step.copy.particles[v]) - load(step.scratch.previous[v]);
    const Vec3<float> velocity = motion.inverse_h * way;
    step.copy.velocities[v] = {velocity.x, velocity.y, velocity.z};
  }
}

void predict_displacements(const StepContext& step, const FreeMotion<float>& motion) {
  const bool has_points = moves_vertices(step.data.options);
  const bool starts = is_explicit(step.data.options);
  const auto predict = [&](std::size_t v, const FreeMotion<float>& falling,
                           const FreeMotion<float>& flying) {
    const float w = step.copy.particles[v].w;
    const Carry& carry = step.copy.carries[v];
    const auto flight_in = [&](const FreeMotion<float>& own) {
      return flight_of(own, load(carry), flying_velocity(own, load(step.copy.velocities[v]), w));
    };
    const Vec3<float> flight = flight_in(flying);
    Vec3<float> u = flight;
    if (has_points) {
      step.scratch.flights[v] = {flight.x, flight.y, flight.z, kFreely};
      u = start_of(falling, step.copy.forces.empty() ? flight : flight_in(falling), w,
                   carry.falling);
      step.scratch.fixed_points[v] = fixed_point(
          load(step.copy.particles[v]), starts ? load(carry) : u, step.data.vertex_blocks.unit());
    }
    step.scratch.displacements[v] = {u.x, u.y, u.z, w};
  };
  for_each_motion(step, motion, predict);
}

void settle_vertices(const StepContext& step, const FreeMotion<float>& motion) {
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    Particle& p = step.copy.particles[v];
    Carry& carry = step.copy.carries[v];
    Velocity& velocity = step.copy.velocities[v];
    const Settled<float> end =
        settle(falling_motion(step.data, motion, static_cast<Index>(v)), load(p), p.w,
               load(velocity), load(carry), load(step.scratch.displacements[v]));
    store(p, end.x);
    velocity = {end.velocity.x, end.velocity.y, end.velocity.z};
    carry = {end.rounding.x, end.rounding.y, end.rounding.z, end.falling};
  }
}

void recall_past(const StepContext& step, float past_share, Index first, Index last) {
  CopyState& copy = step.copy;
  for (Index v = first; v < last; ++v) {
    Way& way = copy.ways[v];
    Velocity& velocity = copy.velocities[v];
    Carry& carry = copy.carries[v];
    const Departure<float> now{load(velocity), load(carry)};
    const Departure<float> next = departure_after(now, copy.particles[v].w, past_share, load(way),
                                                  load(copy.velocities_before[v]));
    way = {carry.x, carry.y, carry.z};  // what the way begins with: see keep_past()
    copy.velocities_before[v] = velocity;
    velocity = {next.velocity.x, next.velocity.y, next.velocity.z};
    carry = {next.rounding.x, next.rounding.y, next.rounding.z, carry.falling};
  }
}

void keep_past(const StepContext& step, Index first, Index last) {
  for (Index v = first; v < last; ++v) {
    Way& way = step.copy.ways[v];
    const Vec3<float> gone = load(step.scratch.displacements[v]) - load(way);
    way = {gone.x, gone.y, gone.z};
  }
}

namespace {

// As a vertex eases off a tool, what the two sides do to each other; by the masses of its corners,
// so momentum stays.
void ease_touch(CopyState& copy, const TissueTouch& touch, float inverse_h) {
  Pushed<float> between;
  Vec3<float> way;
  float yield = 0;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    const Index place = touch.places[k];
    const float weight = touch.weights[k];
    between.velocity = between.velocity + weight * load(copy.velocities[place]);
    between.velocity_before =
        between.velocity_before + weight * load(copy.velocities_before[place]);
    way = way + weight * load(copy.ways[place]);
    yield += weight * weight * copy.particles[place].w;
  }
  if (!(yield > 0)) {
    return;
  }
  const Pushed<float> now = eased(between, touch.normal, way, inverse_h);
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    const Index place = touch.places[k];
    const float share = touch.weights[k] * copy.particles[place].w / yield;
    speed_up(copy.velocities[place], share * (now.velocity - between.velocity));
    speed_up(copy.velocities_before[place],
             share * (now.velocity_before - between.velocity_before));
  }
}

}  // namespace

void ease_contacts(CopyState& copy, float h) {
  const auto ease = [&](Index place, const Vec3<float>& normal) {
    Velocity& velocity = copy.velocities[place];
    Velocity& before = copy.velocities_before[place];
    const Pushed<float> now =
        eased({load(velocity), load(before)}, normal, load(copy.ways[place]), 1 / h);
    velocity = {now.velocity.x, now.velocity.y, now.velocity.z};
    before = {now.velocity_before.x, now.velocity_before.y, now.velocity_before.z};
  };
  for (const ToolState& tool : copy.tools) {
    for (const Contact& contact : tool.contacts) {
      if (contact.multiplier > 0) {
        ease(contact.place, load(contact.normal));
      }
    }
  }
  for (const ToolState& tool : copy.tools) {
    for (const SurfaceContact& contact : tool.surface_contacts) {
      const bool has_to = contact.multiplier > 0 && !contact.is_eased;
      for (int k = 0; k < contact.feature.count() && has_to; ++k) {
        if (copy.particles[contact.feature.places[k]].w > 0) {
          ease(contact.feature.places[k], contact.normal);
        }
      }
    }
  }
  for (const TissueTouch& touch : copy.touches.contacts) {
    if (touch.multiplier > 0 && !touch.is_eased) {
      ease_touch(copy, touch, 1 / h);
    }
  }
}

}  // namespace pbdsurg
