// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What each vertex does for itself in a substep (step_program.h), one after another.

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/methods/displacement.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// Whether displacements are what moves in a substep; else positions do.
[[nodiscard]] PBDSURG_API bool has_displacements(const SolverOptions& options) noexcept;

/// Whether BDF2 takes the substep before into account.
[[nodiscard]] PBDSURG_API bool has_past(const SolverOptions& options) noexcept;

/// Whether the length of the substep before counts.
[[nodiscard]] bool has_past_lengths(const SolverOptions& options) noexcept;

/// What a substep's length comes to.
struct SubstepNumbers {
  FreeMotion<float> motion;
  Substep<float> lengths;
  float past_share = 0;  ///< a of BDF2, see displacement.h
};

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
[[nodiscard]] PBDSURG_API FreeMotion<float> free_motion(const SolverData& data,
                                                        const CopyState& copy, float h) noexcept;

/// Of a vertex, by its gravity; and by the force at it, too.
/// @param motion  of all vertices
[[nodiscard]] FreeMotion<float> falling_motion(const SolverData& data,
                                               const FreeMotion<float>& motion,
                                               Index place) noexcept;
[[nodiscard]] FreeMotion<float> flying_motion(const CopyState& copy,
                                              const FreeMotion<float>& falling,
                                              Index place) noexcept;

/// Explicit steps know velocities half-way through substeps, so that of a first one, when nothing
/// was before, half its length changes them; of others, half of both.
/// @param h        s, of each substep
/// @param substep  of the part of the step, >= 0
[[nodiscard]] PBDSURG_API SubstepNumbers substep_numbers(const SolverData& data,
                                                         const CopyState& copy, float h,
                                                         int substep) noexcept;

[[nodiscard]] MovingVertices moving_vertices(const StepContext& step) noexcept;

/// Where a vertex that has not moved in this substep would be, as MovingVertices count.
[[nodiscard]] Vec3<float> own_start(const StepContext& step, const MovingVertices& vertices,
                                    Index place) noexcept;

/// A vertex goes on by a way, and its fixed point with it, but in explicit steps, whose points are
/// where vertices start. It stays, if it would get to what is not finite.
/// @param way  m
void go_on(const StepContext& step, const MovingVertices& vertices, Index place,
           const Vec3<float>& way);

/// m/s, more than before.
inline void speed_up(Velocity& velocity, const Vec3<float>& by) {
  const Vec3<float> sum = load(velocity) + by;
  velocity = {sum.x, sum.y, sum.z};
}

void predict_positions(const StepContext& step, const FreeMotion<float>& motion);
void update_velocities(const StepContext& step, const FreeMotion<float>& motion);

void predict_displacements(const StepContext& step, const FreeMotion<float>& motion);
void settle_vertices(const StepContext& step, const FreeMotion<float>& motion);

// Of BDF2, each of vertices at [first, last): velocities, carries and what is kept are the next
// substep's between the former and the latter.
void recall_past(const StepContext& step, float past_share, Index first, Index last);
void keep_past(const StepContext& step, Index first, Index last);

/// What tools or other bodies push does not spring back; for pieces that ease_pieces() saw to, that
/// is done.
/// @param h  s, of the substep
void ease_contacts(CopyState& copy, float h);

}  // namespace pbdsurg
