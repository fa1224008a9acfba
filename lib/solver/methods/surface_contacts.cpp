// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/surface_contacts.h"

#include <algorithm>

#include "lib/solver/methods/contact_firmness.h"
#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/coupled_tool.h"
#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/spring_motion.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/touch_search.h"
#include "lib/solver/methods/touched_pieces.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_yield.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

float own_firmness(const StepContext& step, const ToolState& tool, const SurfaceContact& contact) {
  if (contact.capsule == kInvalidIndex) {
    return kPlainFirmness;
  }
  const SweptCapsule swept = swept_capsule(tool, static_cast<std::size_t>(contact.capsule));
  const MovingVertices vertices = moving_vertices(step);
  const float thickness = relative_thickness(swept.now, contact.feature, contact.normal,
                                             [&](Index place) { return vertices.position(place); });
  return firmness_of(step.data.contact_firmness.at(contact.feature.places[0]), thickness,
                     swept.relative_way());
}

// Moves corners by their masses, and the tool by what its spring lets it.
void project(const StepContext& step, ToolState& tool, SurfaceContact& contact, float friction) {
  const MovingVertices vertices = moving_vertices(step);
  ToolSpring& spring = tool.spring;
  float yield = spring.yield;
  for (int k = 0; k < contact.feature.count(); ++k) {
    yield += contact.weights[k] * contact.weights[k] * vertices.moving[contact.feature.places[k]].w;
  }
  project_contact(
      contact, friction, stiffness_of(yield), [&] { return read_contact(vertices, contact, tool); },
      [&](const Vector& push) {
        spring.shift = spring.shift - spring.yield * push;
        for (int k = 0; k < contact.feature.count(); ++k) {
          const Index place = contact.feature.places[k];
          go_on(step, vertices, place, (contact.weights[k] * vertices.moving[place].w) * push);
        }
      });
}

}  // namespace

ContactReading<float> read_contact(const MovingVertices& vertices, const SurfaceContact& contact,
                                   const Vec3<float>& shift) {
  Vector sum;
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + contact.weights[k] * load(vertices.moving[contact.feature.places[k]]);
  }
  return read_plane(contact, sum - shift);
}

bool meets_surfaces(const StepContext& step) noexcept {
  return std::ranges::any_of(step.copy.tools, &ToolState::has_surface);
}

void begin_surface_contacts(const StepContext& step, const VertexState& state) {
  const MovingVertices vertices = moving_vertices(step);
  const auto is_likely = [&](const SurfaceContact& contact, const ToolState& tool) {
    return contact.multiplier > 0 || read_contact(vertices, contact, tool).gap < 0;
  };
  // What others do at a corner: how often it is pushed, in all.
  const auto pushes_at = [&](Index place, const SurfaceContact& own, const ToolState& tool,
                             float weight) {
    float sum = is_likely(own, tool) ? 0 : weight;
    for (Index h = step.scratch.first_holds[place]; h != kInvalidIndex;
         h = step.scratch.holds[h].next) {
      const VertexHold& hold = step.scratch.holds[h];
      if (hold.kind == HoldKind::surface_contact) {
        const ToolState& its_tool = step.copy.tools[hold.tool];
        const SurfaceContact& other = its_tool.surface_contacts[hold.entry];
        sum += is_likely(other, its_tool) ? other.weights[hold.corner] : 0;
      }
    }
    return sum;
  };
  for (ToolState& tool : step.copy.tools) {
    const float spring = stiffness_of(tool.spring, state.inverse_dt_squared);
    for (SurfaceContact& contact : tool.surface_contacts) {
      float yield = 0;
      for (int k = 0; k < contact.feature.count(); ++k) {
        const Index place = contact.feature.places[k];
        const float weight = contact.weights[k];
        yield += weight * pushes_at(place, contact, tool, weight) *
                 yield_of(step, state, place, contact.normal);
      }
      contact.stiffness = met_stiffness(own_firmness(step, tool, contact), yield, spring);
    }
  }
}

void add_surface_contact(const StepContext& step, const SurfaceContact& contact, int corner,
                         const ToolState& tool, float inverse_dt_squared,
                         VertexEnergy<float>& energy) {
  add_answer(
      contact,
      answer(contact, tool.surface.friction, read_contact(moving_vertices(step), contact, tool),
             inverse_dt_squared, contact.stiffness),
      contact.weights[corner], energy);
}

void project_surface_contacts(const StepContext& step, Index tool_index) {
  ToolState& tool = step.copy.tools[tool_index];
  for (SurfaceContact& contact : tool.surface_contacts) {
    project(step, tool, contact, tool.surface.friction);
  }
}

void answer_surface_contacts(const StepContext& step, const Substep<float>& lengths) {
  if (!has_touches(step)) {  // else answer_touches() has done it
    balance_pieces(step, lengths);
  }
  const MovingVertices vertices = moving_vertices(step);
  const float square = 1 / lengths.inverse_dt_squared;
  for (ToolState& tool : step.copy.tools) {
    balance_coupling(step, lengths, tool);
    for (SurfaceContact& contact : tool.surface_contacts) {
      take_over(contact,
                answer(contact, tool.surface.friction, read_contact(vertices, contact, tool),
                       lengths.inverse_dt_squared, contact.stiffness)
                    .force,
                square);
      follow_feature(step, tool, contact);
    }
  }
}

void push_out_of_surfaces(const StepContext& step) {
  for (int pass = 0; pass < kPushPasses; ++pass) {
    project_touches(step);
    for (Index tool = 0; tool < static_cast<Index>(step.copy.tools.size()); ++tool) {
      project_surface_contacts(step, tool);
    }
  }
}

void settle_surface_contacts(const StepContext& step) {
  bool is_any_inside = true;
  for (int pass = 0; pass < kSettlePasses && is_any_inside; ++pass) {
    is_any_inside = false;
    for (ToolState& tool : step.copy.tools) {
      for (SurfaceContact& contact : tool.surface_contacts) {
        if (read_contact(moving_vertices(step), contact, tool).gap < 0) {
          project(step, tool, contact, 0);
          is_any_inside = true;
        }
      }
    }
  }
  for (ToolState& tool : step.copy.tools) {
    for (SurfaceContact& contact : tool.surface_contacts) {
      contact.is_left_inside = is_left_inside(read_contact(moving_vertices(step), contact, tool));
    }
  }
}

}  // namespace pbdsurg
