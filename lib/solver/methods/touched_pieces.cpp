// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touched_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/moving_piece.h"
#include "lib/solver/methods/piece_easing.h"
#include "lib/solver/methods/rigid_balance.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Calls visit(piece) for those that surfaces touch and nothing else holds.
template <class Visit>
void for_each_touched(const StepContext& step, const Visit& visit) {
  if (std::ranges::all_of(step.copy.tools,
                          [](const ToolState& tool) { return tool.surface_contacts.empty(); })) {
    return;
  }
  for (Index i = 0; i < step.data.free_pieces.count(); ++i) {
    const MovingPiece piece(step, i);
    bool is_touched = false, is_held = false;
    piece.for_each_hold([&](const VertexHold& hold) {
      const bool touches = hold.kind == HoldKind::surface_contact;
      is_touched = is_touched || touches;
      is_held = is_held || !touches;
    });
    if (is_touched && !is_held) {
      visit(piece);
    }
  }
}

// Calls visit(contact, tool) for those of a piece, in the order of tools and features.
template <class Visit>
void for_each_contact(const StepContext& step, const MovingPiece& piece, const Visit& visit) {
  std::vector<ContactEntry>& entries = step.scratch.contact_entries;
  entries.clear();
  piece.for_each_hold([&](const VertexHold& hold) {
    if (hold.corner == 0) {
      entries.push_back({hold.tool, hold.entry});
    }
  });
  std::ranges::sort(entries);
  for (const auto& [index, entry] : entries) {
    ToolState& tool = step.copy.tools[index];
    visit(tool.surface_contacts[entry], tool);
  }
}

// The weighted sum of what arm(place) says of a contact's corners.
template <class Arm>
Vec3<double> arm_at(const SurfaceContact& contact, const Arm& arm) {
  Vec3<double> sum{0, 0, 0};
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + static_cast<double>(contact.weights[k]) * arm(contact.feature.places[k]);
  }
  return sum;
}

void find_rigid_contacts(const StepContext& step, const MovingPiece& piece,
                         const Vec3<double>& centre, float inverse_dt_squared) {
  std::vector<RigidContact>& contacts = step.scratch.rigid_contacts;
  contacts.clear();
  const MovingVertices vertices = moving_vertices(step);
  for_each_contact(step, piece, [&](const SurfaceContact& contact, const ToolState& tool) {
    const ContactReading<float> now = read_contact(vertices, contact, tool);
    if (!std::isfinite(now.gap) || !is_finite_way(now.slip)) {
      return;
    }
    const Vec3<double> arm = arm_at(contact, [&](Index place) { return piece.arm(place); });
    contacts.push_back({arm - centre,
                        to_double(contact.normal),
                        {now.gap, to_double(now.slip)},
                        {contact.multiplier, to_double(contact.friction)},
                        tool.surface.friction,
                        static_cast<double>(contact.stiffness) / inverse_dt_squared});
  });
}

void move(const StepContext& step, const MovingPiece& piece, const RigidMove& rigid) {
  const MovingVertices vertices = moving_vertices(step);
  for (const Index place : piece.places()) {
    if (piece.counts(place)) {
      go_on(step, vertices, place, part_of(rigid, piece.arm(place)));
    }
  }
}

// Calls add(sum, place, mass) for all vertices of a piece that count, and adds up the sums.
template <class Sums, class Add>
Sums sum_over(const StepContext& step, const MovingPiece& piece, const Add& add) {
  std::array<Sums, kMomentumSums> sums;
  const std::span<const Index> places = piece.places();
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (piece.counts(places[i])) {
      const double mass = 1 / static_cast<double>(step.copy.particles[places[i]].w);
      add(sums[i % kMomentumSums], places[i], mass);
    }
  }
  return total(sums);
}

Pushes pushes_on(const StepContext& step, const MovingPiece& piece) {
  const auto position = [&](Index place) { return to_double(load(step.copy.particles[place])); };
  const auto add = [&](MomentumSums& sums, Index place, double mass) {
    sums.add(mass, position(place), {0, 0, 0});
  };
  Pushes pushes{sum_over<MomentumSums>(step, piece, add)};
  for_each_contact(step, piece, [&](const SurfaceContact& contact, const ToolState& /*tool*/) {
    pushes.add(contact.multiplier, contact.normal, arm_at(contact, position));
  });
  return pushes;
}

Easing easing_along(const StepContext& step, const MovingPiece& piece, const Pushes& pushes,
                    const RigidMove& pushed, float h) {
  const CopyState& copy = step.copy;
  const auto add = [&](EasingSums& sums, Index place, double mass) {
    const Vec3<double> along = to_double(part_of(pushed, to_double(load(copy.particles[place]))));
    sums.add(mass, along, load(copy.velocities[place]), load(copy.ways[place]),
             load(copy.velocities_before[place]), h);
  };
  return sum_over<EasingSums>(step, piece, add).easing(pushes);
}

void add(Velocity& velocity, const Vec3<float>& more) {
  const Vec3<float> sum = load(velocity) + more;
  velocity = {sum.x, sum.y, sum.z};
}

}  // namespace

void balance_pieces(const StepContext& step, const Substep<float>& lengths) {
  for_each_touched(step, [&](const MovingPiece& piece) {
    const MomentumSums sums = piece.momentum();
    if (!(sums.mass > 0)) {
      return;
    }
    find_rigid_contacts(step, piece, sums.centre(), lengths.inverse_dt_squared);
    const std::vector<RigidContact>& contacts = step.scratch.rigid_contacts;
    const Screw twist =
        RigidBalance(sums, contacts.data(), static_cast<Index>(contacts.size())).twist();
    move(step, piece, {twist.linear, twist.angular, sums.centre()});
  });
}

void ease_pieces(const StepContext& step) {
  CopyState& copy = step.copy;
  const StepPart& part = step.data.part;
  for_each_touched(step, [&](const MovingPiece& piece) {
    const Pushes pushes = pushes_on(step, piece);
    const RigidMove pushed = pushes.sums.rigid_move();
    const Easing easing = easing_along(step, piece, pushes, pushed, part.h);
    for (const Index place : piece.places()) {
      if (piece.counts(place)) {
        const Vec3<float> along = part_of(pushed, to_double(load(copy.particles[place])));
        add(copy.velocities[place], static_cast<float>(easing.now) * along);
        add(copy.velocities_before[place], static_cast<float>(easing.before) * along);
      }
    }
    // in substeps of one length these velocities count so much for all that are to come
    const float relief = relief_of(easing, part.h, part.per_step, copy.factors.density);
    for_each_contact(step, piece, [&](SurfaceContact& contact, ToolState& /*tool*/) {
      contact.is_eased = true;
      contact.relief = relief;
    });
  });
  for (ToolState& tool : copy.tools) {
    for (const SurfaceContact& contact : tool.surface_contacts) {
      if (contact.is_eased) {
        feel_contact(contact, contact.multiplier * contact.normal, contact.relief, tool);
      }
    }
  }
}

}  // namespace pbdsurg
