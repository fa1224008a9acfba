// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that surfaces of tools or other bodies touch, of the vertex-block method. A sweep
/// moves a vertex by what its neighbours leave it, which is far less than how a whole piece has to
/// go, so sweeps that end early would hold to a surface what should slide on it. So the piece moves
/// as a rigid body, too: see group_balance.h. Pieces that touch each other move at once, so that
/// what a contact gives to one it takes from the other.
///
/// What a tool holds or touches without a surface has no such motion, and neither has what custom
/// constraints push from outside. One after another, in one order, by one thread. Cost, after each
/// sweep: two passes over the vertices of touched pieces and some twenty over their contacts, which
/// is a sixth of the step of a flat block that lies on a third of its vertices.

#include <algorithm>
#include <vector>

#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/moving_piece.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Lists what has such a motion into StepScratch::touched, and groups what touches each other.
void list_touched_pieces(const StepContext& step);

/// Before contacts take over their forces, at the end of a sweep: moves each touched piece to where
/// these forces are what its momentum has changed by.
/// @param lengths  of the substep
void balance_pieces(const StepContext& step, const Substep<float>& lengths);

/// What of StepScratch::touched a place belongs to, or kInvalidIndex; while bodies meet.
[[nodiscard]] Index find_touched(const StepContext& step, Index place);

/// By which a piece that is listed moves with others.
[[nodiscard]] const PushedPieces* groups_of(const StepContext& step);

/// Calls visit_surface(contact, tool) for what tools touch of a piece, in the order of tools and
/// features, and visit_touch(touch, side) for its contacts with other bodies, of which it has a
/// side.
template <class VisitSurface, class VisitTouch>
void for_each_contact(const StepContext& step, const MovingPiece& piece,
                      const VisitSurface& visit_surface, const VisitTouch& visit_touch) {
  std::vector<ContactEntry>& entries = step.scratch.contact_entries;
  entries.clear();
  piece.for_each_hold([&](const VertexHold& hold) {
    const bool is_touch = hold.kind == HoldKind::touch;
    if (is_touch) {
      const TissueTouch& touch = step.copy.touches.contacts[hold.entry];
      entries.push_back({hold.tool, hold.entry, touch.side_of(hold.corner)});
    } else if (hold.corner == 0) {
      entries.push_back({hold.tool, hold.entry, 0});
    }
  });
  std::ranges::sort(entries);
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  for (const auto& [index, entry, side] : entries) {
    if (index == kInvalidIndex) {
      visit_touch(step.copy.touches.contacts[entry], side);
    } else {
      ToolState& tool = step.copy.tools[index];
      visit_surface(tool.surface_contacts[entry], tool);
    }
  }
}

/// The weighted sum of what arm(place) says of the corners of a contact that are on a side.
template <class Arm>
[[nodiscard]] Vec3<double> arm_at(const SurfaceContact& contact, const Arm& arm) {
  Vec3<double> sum{0, 0, 0};
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + static_cast<double>(contact.weights[k]) * arm(contact.feature.places[k]);
  }
  return sum;
}
template <class Arm>
[[nodiscard]] Vec3<double> arm_at(const TissueTouch& touch, int side, const Arm& arm) {
  const double sign = side == 0 ? 1 : -1;
  Vec3<double> sum{0, 0, 0};
  for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
    sum = sum + sign * static_cast<double>(touch.weights[k]) * arm(touch.places[k]);
  }
  return sum;
}

}  // namespace pbdsurg
