// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What each vertex does for itself in a substep (step_program.h), one after another.

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/methods/displacement.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// Whether displacements are what moves in a substep; else positions do.
[[nodiscard]] PBDSURG_API bool has_displacements(const SolverOptions& options) noexcept;

/// The vertices of a copy within a substep.
struct MovingVertices {
  Particle* moving;              ///< [place] m
  const Particle* bases;         ///< [place] m, from where `moving` counts; null: from the origin
  FixedPoint* points = nullptr;  ///< [place] of the vertex-block method

  [[nodiscard]] Vec3<float> base(Index place) const {
    return bases == nullptr ? Vec3<float>{} : load(bases[place]);
  }
  [[nodiscard]] Vec3<float> position(Index place) const {
    return base(place) + load(moving[place]);
  }
};

/// @param h  s, of a substep
[[nodiscard]] PBDSURG_API FreeMotion<float> free_motion(const SolverData& data, float h) noexcept;

[[nodiscard]] MovingVertices moving_vertices(const StepContext& step) noexcept;

void predict_positions(const StepContext& step, const FreeMotion<float>& motion);
void update_velocities(const StepContext& step, const FreeMotion<float>& motion);

void predict_displacements(const StepContext& step, const FreeMotion<float>& motion);
void settle_vertices(const StepContext& step, const FreeMotion<float>& motion);

}  // namespace pbdsurg
