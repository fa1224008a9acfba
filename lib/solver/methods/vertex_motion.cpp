// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_motion.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

bool has_displacements(const SolverOptions& options) noexcept {
  return options.mode == ProjectionMode::compliance;
}

FreeMotion<float> free_motion(const SolverData& data, float h) noexcept {
  const Vec3<float> gravity = load(data.gravity);
  const float square = dot(gravity, gravity);
  return {h,
          1 / h,
          1 / (1 + data.options.damping * h),
          h * gravity,
          (h * h) * gravity,
          (square > 0 ? 1 / square : 0.0F) * gravity};
}

MovingVertices moving_vertices(const StepContext& step) noexcept {
  if (has_displacements(step.data.options)) {
    const bool has_points = step.data.options.method == SolverMethod::vertex_block;
    return {step.scratch.displacements.data(), step.copy.particles.data(),
            has_points ? step.scratch.fixed_points.data() : nullptr};
  }
  return {step.copy.particles.data(), nullptr};
}

void predict_positions(const StepContext& step, const FreeMotion<float>& motion) {
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    Particle& p = step.copy.particles[v];
    step.scratch.previous[v] = p;
    if (p.w > 0) {
      store(p, load(p) + motion.h * (motion.keep * load(step.copy.velocities[v]) + motion.kick));
    }
  }
}

void update_velocities(const StepContext& step, const FreeMotion<float>& motion) {
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    const Vec3<float> way = load(step.copy.particles[v]) - load(step.scratch.previous[v]);
    const Vec3<float> velocity = motion.inverse_h * way;
    step.copy.velocities[v] = {velocity.x, velocity.y, velocity.z};
  }
}

void predict_displacements(const StepContext& step, const FreeMotion<float>& motion) {
  const bool extrapolates = step.data.options.method == SolverMethod::vertex_block;
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    const float w = step.copy.particles[v].w;
    const Carry& carry = step.copy.carries[v];
    const Vec3<float> flight =
        flight_of(motion, load(carry), flying_velocity(motion, load(step.copy.velocities[v]), w));
    Vec3<float> u = flight;
    if (extrapolates) {
      step.scratch.flights[v] = {flight.x, flight.y, flight.z, kFreely};
      u = start_of(motion, flight, w, carry.falling);
      step.scratch.fixed_points[v] =
          fixed_point(load(step.copy.particles[v]), u, step.data.vertex_blocks.unit());
    }
    step.scratch.displacements[v] = {u.x, u.y, u.z, w};
  }
}

void settle_vertices(const StepContext& step, const FreeMotion<float>& motion) {
  for (std::size_t v = 0; v < step.copy.particles.size(); ++v) {
    Particle& p = step.copy.particles[v];
    Carry& carry = step.copy.carries[v];
    Velocity& velocity = step.copy.velocities[v];
    const Settled<float> end = settle(motion, load(p), p.w, load(velocity), load(carry),
                                      load(step.scratch.displacements[v]));
    store(p, end.x);
    velocity = {end.velocity.x, end.velocity.y, end.velocity.z};
    carry = {end.rounding.x, end.rounding.y, end.rounding.z, end.falling};
  }
}

}  // namespace pbdsurg
