// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which vertices, edges and triangles a tool meets in a substep, and where.

#include <span>

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/near_features.h"
#include "lib/solver/state/tool_state.h"

namespace pbdsurg {

/// Finds the contacts of one tool: every vertex, edge and triangle that is within a quarter of a
/// capsule's radius of it where the substep ends, and all that it has gone through on its way. An
/// edge is met where it is nearest to the axis, but not at its ends; a triangle where an end of the
/// axis is straight above it, or the axis pierces it; so each place of touch belongs to one of
/// them. A feature stays on the side where the tool met it first, for as long as they are near.
///
/// Cost: O(n log n) of n near ones, O(n) for each that is met and was not before, and
/// O(vertices + triangles) where near ones are not listed.
/// @param tool     placed at the end of the substep and, in `capsules_before`, at its start
/// @param near     what its capsules may touch; null: anything
/// @param lengths  of the substep
void find_surface_contacts(const StepContext& step, ToolState& tool, const NearFeatures* near,
                           const Substep<float>& lengths, StepReport& report);

/// Turns the plane of a tool's contact to where sweeps have moved its feature: see turn_to().
void follow_feature(const StepContext& step, const ToolState& tool, SurfaceContact& contact);

/// m, of a vertex as the substep began.
[[nodiscard]] Vec3<float> start_of(const StepContext& step, const MovingVertices& vertices,
                                   Index place);

/// Of a feature through the substep, to where its vertices are now.
/// @param places  one to three
[[nodiscard]] FeatureCorners corners_of(const StepContext& step, std::span<const Index> places);

[[nodiscard]] inline PlacedCapsule placed(const Capsule& capsule) {
  return {load(capsule.start), capsule.radius, load(capsule.end), load(capsule.across)};
}

// Of a tool through a substep, but for its displacement.

/// A capsule.
[[nodiscard]] inline SweptCapsule swept_capsule(const ToolState& tool, std::size_t capsule) {
  return {placed(tool.capsules_before[capsule]), placed(tool.placed_capsules[capsule])};
}

/// m, of its origin.
[[nodiscard]] PBDSURG_API Vec3<float> told_way(const ToolState& tool);

/// m, the longest way of an end of its capsules.
[[nodiscard]] PBDSURG_API float way_of(const ToolState& tool);

/// What holds all that it may touch.
[[nodiscard]] PBDSURG_API ContactBox swept_box(const ToolState& tool);

/// One of its half spaces. A rotation within floats' rounding of one turns
/// nothing: what sticks to a tool at rest does not creep.
[[nodiscard]] PBDSURG_API SweptHalfSpace swept_half_space(const ToolState& tool,
                                                          const HalfSpace& half_space);

/// Keeps what the next substep has to know.
/// @param inverse_dt_squared  1/s^2, of this substep
void remember_contacts(ToolState& tool, float inverse_dt_squared);

}  // namespace pbdsurg
