// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touched_pieces.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lib/solver/methods/moving_piece.h"
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

// Calls visit(contact, friction) for those of a piece.
template <class Visit>
void for_each_contact(const StepContext& step, const MovingPiece& piece, const Visit& visit) {
  piece.for_each_hold([&](const VertexHold& hold) {
    if (hold.corner == 0) {
      const ToolState& tool = step.copy.tools[hold.tool];
      visit(tool.surface_contacts[hold.entry], tool.surface.friction);
    }
  });
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
  for_each_contact(step, piece, [&](const SurfaceContact& contact, float friction) {
    const ContactReading<float> now = read_contact(vertices, contact);
    if (!std::isfinite(now.gap) || !is_finite_way(now.slip)) {
      return;
    }
    const Vec3<double> arm = arm_at(contact, [&](Index place) { return piece.arm(place); });
    contacts.push_back({arm - centre,
                        to_double(contact.normal),
                        {now.gap, to_double(now.slip)},
                        {contact.multiplier, to_double(contact.friction)},
                        friction,
                        static_cast<double>(contact.stiffness) / inverse_dt_squared});
  });
}

void move(const StepContext& step, const MovingPiece& piece, const RigidMove& rigid) {
  for (const Index place : piece.places()) {
    Particle& p = step.scratch.displacements[place];
    const Vec3<float> before = load(p);
    const Vec3<float> after = before + part_of(rigid, piece.arm(place));
    if (piece.counts(place) && is_finite_way(after)) {
      store(p, after);
      FixedPoint& point = step.scratch.fixed_points[place];
      point = moved_point(point, before, after);
    }
  }
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

void ease_pieces(const StepContext& step, float h) {
  CopyState& copy = step.copy;
  const auto position = [&](Index place) { return to_double(load(copy.particles[place])); };
  const auto mass = [&](Index place) { return 1 / static_cast<double>(copy.particles[place].w); };
  for_each_touched(step, [&](const MovingPiece& piece) {
    MomentumSums sums;
    for (const Index place : piece.places()) {
      if (piece.counts(place)) {
        sums.add(mass(place), position(place), {0, 0, 0});
      }
    }
    for_each_contact(step, piece, [&](const SurfaceContact& contact, float /*friction*/) {
      const Vec3<double> push = to_double(contact.multiplier * contact.normal);
      sums.gain = sums.gain + push;
      sums.moment = sums.moment + cross(arm_at(contact, position), push);
    });
    const RigidMove pushed = sums.rigid_move();
    // along that, per square of it
    double square = 0, speed = 0, mean = 0, speed_before = 0;
    for (const Index place : piece.places()) {
      if (piece.counts(place)) {
        const Vec3<double> along = mass(place) * to_double(part_of(pushed, position(place)));
        square += dot(along, along) / mass(place);
        speed += dot(along, to_double(load(copy.velocities[place])));
        mean += dot(along, to_double(load(copy.ways[place]))) / h;
        speed_before += dot(along, to_double(load(copy.velocities_before[place])));
      }
    }
    if (!(square > 0)) {
      return;
    }
    const double less = std::min(0.0, mean - speed) / square;
    const double gain = std::max(0.0, (speed - speed_before) / square + less);
    for (const Index place : piece.places()) {
      if (piece.counts(place)) {
        const Vec3<float> part = part_of(pushed, position(place));
        add(copy.velocities[place], static_cast<float>(less) * part);
        add(copy.velocities_before[place], static_cast<float>(gain) * part);
      }
    }
  });
}

}  // namespace pbdsurg
