// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touched_pieces.h"

#include <cmath>

#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/group_balance.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/methods/workers.h"

namespace pbdsurg {
namespace {

// A contact as one side has it. The second sees it from behind.
template <class Contact>
RigidContact rigid_contact(const Contact& contact, int side, const ContactReading<float>& now,
                           const Vec3<double>& arm, float friction, float inverse_dt_squared) {
  const double sign = side == 0 ? 1 : -1;
  return {arm,
          sign * to_double(contact.normal),
          {now.gap, sign * to_double(now.slip)},
          {contact.multiplier, sign * to_double(contact.friction)},
          friction,
          static_cast<double>(contact.stiffness) / inverse_dt_squared};
}

bool is_finite(const ContactReading<float>& now) {
  return std::isfinite(now.gap) && is_finite_way(now.slip);
}

// Adds the contacts of a piece to those of its group, but those that an earlier piece has added.
void add_contacts(const StepContext& step, Index index, float inverse_dt_squared) {
  const TouchedPieces& touched = step.scratch.touched;
  const TouchedPiece& own = touched[index];
  const MovingPiece piece(step, own.piece, groups_of(step));
  std::vector<GroupContact>& contacts = step.scratch.group_contacts;
  const MovingVertices vertices = moving_vertices(step);
  const auto arm = [&](Index place) { return piece.arm(place); };
  const auto add_surface = [&](const SurfaceContact& contact, const ToolState& tool) {
    const ContactReading<float> now = read_contact(vertices, contact, tool);
    if (is_finite(now)) {
      contacts.push_back({rigid_contact(contact, 0, now, arm_at(contact, arm) - own.sums.centre(),
                                        tool.surface.friction, inverse_dt_squared),
                          own.rank});
    }
  };
  const auto add_touch = [&](const TissueTouch& touch, int side) {
    const ContactReading<float> now = read_touch(vertices, touch);
    const Index other = find_touched(step, touch.place_on(1 - side));
    const bool is_pair = other != kInvalidIndex && touched[other].group == own.group;
    if (!is_finite(now) || other == index || (is_pair && other < index)) {
      return;
    }
    GroupContact contact{
        rigid_contact(touch, side, now, arm_at(touch, side, arm) - own.sums.centre(), touch.mu,
                      inverse_dt_squared),
        own.rank};
    if (is_pair) {
      contact.second = touched[other].rank;
      contact.other_arm = arm_at(touch, 1 - side, arm) - touched[other].sums.centre();
    }
    contacts.push_back(contact);
  };
  for_each_contact(step, piece, add_surface, add_touch);
}

void move(const StepContext& step, const TouchedPiece& touched, const Screw& twist) {
  const MovingPiece piece(step, touched.piece, groups_of(step));
  const MovingVertices vertices = moving_vertices(step);
  const RigidMove rigid{twist.linear, twist.angular, touched.sums.centre()};
  piece.for_each_place([&](Index place) {
    if (piece.counts(place)) {
      go_on(step, vertices, place, part_of(rigid, piece.arm(place)));
    }
  });
}

void balance_group(const StepContext& step, Index group, float inverse_dt_squared) {
  const TouchedPieces& touched = step.scratch.touched;
  std::vector<RigidBody>& bodies = step.scratch.group_bodies;
  bodies.clear();
  step.scratch.group_contacts.clear();
  for (Index i = group; i < touched.count(); ++i) {
    if (touched[i].group == group) {
      bodies.emplace_back(touched[i].sums);
      add_contacts(step, i, inverse_dt_squared);
    }
  }
  const std::vector<GroupContact>& contacts = step.scratch.group_contacts;
  step.scratch.group_answers.resize(contacts.size());
  GroupSpace& space = step.scratch.group_space.front();
  GroupBalance(OneWorker{}, bodies.data(), static_cast<Index>(bodies.size()), contacts.data(),
               static_cast<Index>(contacts.size()), step.scratch.group_answers.data(), space)
      .run();
  for (Index i = group; i < touched.count(); ++i) {
    if (touched[i].group == group) {
      move(step, touched[i], space.twist_of(touched[i].rank));
    }
  }
}

}  // namespace

void list_touched_pieces(const StepContext& step) {
  TouchedPieces& touched = step.scratch.touched;
  touched.begin(step.data.free_pieces.count());
  const std::vector<TissueTouch>& touches = step.copy.touches.contacts;
  if (touches.empty() && std::ranges::all_of(step.copy.tools, [](const ToolState& tool) {
        return tool.surface_contacts.empty();
      })) {
    return;
  }
  for (Index i = 0; i < step.data.free_pieces.count(); ++i) {
    const MovingPiece piece(step, i, groups_of(step));
    bool is_touched = false, is_held = false;
    piece.for_each_hold([&](const VertexHold& hold) {
      const bool is_touch = hold.kind == HoldKind::surface_contact || hold.kind == HoldKind::touch;
      is_touched = is_touched || is_touch;
      is_held = is_held || !is_touch;
    });
    if (!is_touched || is_held) {
      continue;
    }
    if (const MomentumSums sums = piece.momentum(); sums.mass > 0) {
      touched.add(i, sums);
    }
  }
  for (const TissueTouch& touch : touches) {
    const Index a = find_touched(step, touch.place_on(0)),
                b = find_touched(step, touch.place_on(1));
    if (a != kInvalidIndex && b != kInvalidIndex) {
      touched.join(a, b);
    }
  }
  touched.rank();
}

void balance_pieces(const StepContext& step, const Substep<float>& lengths) {
  list_touched_pieces(step);
  const TouchedPieces& touched = step.scratch.touched;
  for (Index i = 0; i < touched.count(); ++i) {
    if (touched[i].group == i) {
      balance_group(step, i, lengths.inverse_dt_squared);
    }
  }
}

Index find_touched(const StepContext& step, Index place) {
  if (step.scratch.touched.count() == 0) {  // as of projections, which have no pieces
    return kInvalidIndex;
  }
  const Index piece = step.scratch.pushed.group_at(place);
  return piece == kInvalidIndex ? kInvalidIndex : step.scratch.touched.find(piece);
}

const PushedPieces* groups_of(const StepContext& step) {
  return has_custom(step) ? &step.scratch.pushed : nullptr;
}

}  // namespace pbdsurg
