// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/surface_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/contact_answer.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/loose_end.h"
#include "lib/solver/methods/touched_pieces.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

// The stiffness of a contact over that of its corners, as far as its neighbours leave it alone.
constexpr float kFirmness = 1;

ContactAnswer<float> answer(const SurfaceContact& contact, float friction,
                            const ContactReading<float>& reading, float scale, float stiffness) {
  return contact_answer({scale * contact.multiplier, scale * contact.friction}, friction, reading,
                        stiffness);
}

bool is_finite(const ContactForce<float>& force) {
  return std::isfinite(force.push) && is_finite_way(force.drag);
}

void move(const StepContext& step, const MovingVertices& vertices, const SurfaceContact& contact,
          const Vector& push) {
  for (int k = 0; k < contact.feature.count(); ++k) {
    const Index place = contact.feature.places[k];
    Particle& p = vertices.moving[place];
    const Vector before = load(p);
    const Vector after = before + (contact.weights[k] * p.w) * push;
    if (!is_finite_way(after)) {
      continue;
    }
    store(p, after);
    if (vertices.points != nullptr) {
      FixedPoint& point = step.scratch.fixed_points[place];
      point = moved_point(point, before, after);
    }
  }
}

// Moves corners by their masses.
void project(const StepContext& step, SurfaceContact& contact, float friction) {
  const MovingVertices vertices = moving_vertices(step);
  float yield = 0;
  for (int k = 0; k < contact.feature.count(); ++k) {
    yield += contact.weights[k] * contact.weights[k] * vertices.moving[contact.feature.places[k]].w;
  }
  if (!(yield > 0)) {
    return;
  }
  const auto project_once = [&](float mu) {
    const ContactForce<float> now =
        answer(contact, mu, read_contact(vertices, contact), 1, 1 / yield).force;
    if (!is_finite(now)) {
      return;
    }
    const Vector drag = mu > 0 ? now.drag - contact.friction : Vector{};
    const Vector push = (now.push - contact.multiplier) * contact.normal + drag;
    contact.multiplier = now.push;
    if (mu > 0) {
      contact.friction = now.drag;
    }
    move(step, vertices, contact, push);
  };
  project_once(0);
  if (friction > 0) {
    project_once(friction);
  }
}

// m/N along a direction, of a vertex that its neighbours hold.
float yield_of(const StepContext& step, const VertexState& state, Index place,
               const Vector& normal) {
  const auto [block_index, lane] = step.data.vertex_blocks.place_of(place);
  const Particle& p = state.displacements[place];
  if (block_index == kInvalidIndex || !(p.w > 0) || is_lost(state.fixed_points[place])) {
    return 0;
  }
  const VertexRows rows = vertex_rows(step);
  VertexEnergy<float> start;
  start.add_pull(state.inverse_dt_squared / p.w, load(state.flights[place]) - load(p));
  const LaneAccess access{state.fixed_points, state.fixed_points[place], lane};
  const HeldVertex held(step, {load(state.bases[place]), load(p)}, step.scratch.first_holds[place]);
  const LooseEnd<float> end = find_loose_end(rows, rows.blocks[block_index], access, start, held);
  return dot(normal, end.give * normal);
}

}  // namespace

ContactReading<float> read_contact(const MovingVertices& vertices, const SurfaceContact& contact) {
  Vector sum;
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + contact.weights[k] * load(vertices.moving[contact.feature.places[k]]);
  }
  const Vector way = sum - contact.drift;
  return {dot(contact.normal, sum) - contact.offset,
          way - dot(contact.normal, way) * contact.normal};
}

bool meets_surfaces(const StepContext& step) noexcept {
  return std::ranges::any_of(step.copy.tools, &ToolState::has_surface);
}

void begin_surface_contacts(const StepContext& step, const VertexState& state) {
  const MovingVertices vertices = moving_vertices(step);
  const auto is_likely = [&](const SurfaceContact& contact) {
    return contact.multiplier > 0 || read_contact(vertices, contact).gap < 0;
  };
  // What others do at a corner: how often it is pushed, in all.
  const auto pushes_at = [&](Index place, const SurfaceContact& own, float weight) {
    float sum = is_likely(own) ? 0 : weight;
    for (Index h = step.scratch.first_holds[place]; h != kInvalidIndex;
         h = step.scratch.holds[h].next) {
      const VertexHold& hold = step.scratch.holds[h];
      if (hold.kind == HoldKind::surface_contact) {
        const SurfaceContact& other = step.copy.tools[hold.tool].surface_contacts[hold.entry];
        sum += is_likely(other) ? other.weights[hold.corner] : 0;
      }
    }
    return sum;
  };
  for (ToolState& tool : step.copy.tools) {
    for (SurfaceContact& contact : tool.surface_contacts) {
      float yield = 0;
      for (int k = 0; k < contact.feature.count(); ++k) {
        const Index place = contact.feature.places[k];
        const float weight = contact.weights[k];
        yield += weight * pushes_at(place, contact, weight) *
                 yield_of(step, state, place, contact.normal);
      }
      contact.stiffness = yield > 0 ? kFirmness / yield : 0.0F;
    }
  }
}

void add_surface_contact(const StepContext& step, const SurfaceContact& contact, int corner,
                         float friction, float inverse_dt_squared, VertexEnergy<float>& energy) {
  const float stiffness = contact.stiffness;
  const auto [force, sticking] =
      answer(contact, friction, read_contact(moving_vertices(step), contact), inverse_dt_squared,
             stiffness);
  if (!(force.push > 0)) {
    return;
  }
  const float weight = contact.weights[corner];
  const float square = weight * weight * stiffness;
  energy.force = energy.force + weight * (force.push * contact.normal + force.drag);
  energy.isotropic = energy.isotropic + sticking * square;
  energy.add_square((1 - sticking) * square, contact.normal);
}

void project_surface_contacts(const StepContext& step, Index tool_index) {
  ToolState& tool = step.copy.tools[tool_index];
  for (SurfaceContact& contact : tool.surface_contacts) {
    project(step, contact, tool.surface.friction);
  }
}

void answer_surface_contacts(const StepContext& step, const Substep<float>& lengths) {
  balance_pieces(step, lengths);
  const MovingVertices vertices = moving_vertices(step);
  const float square = 1 / lengths.inverse_dt_squared;
  for (ToolState& tool : step.copy.tools) {
    for (SurfaceContact& contact : tool.surface_contacts) {
      const ContactForce<float> now =
          answer(contact, tool.surface.friction, read_contact(vertices, contact),
                 lengths.inverse_dt_squared, contact.stiffness)
              .force;
      if (is_finite(now)) {
        contact.multiplier = square * now.push;
        contact.friction = square * now.drag;
      }
    }
  }
}

void settle_surface_contacts(const StepContext& step) {
  for (ToolState& tool : step.copy.tools) {
    for (SurfaceContact& contact : tool.surface_contacts) {
      if (read_contact(moving_vertices(step), contact).gap < 0) {
        project(step, contact, 0);
      }
    }
  }
}

}  // namespace pbdsurg
