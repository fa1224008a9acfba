// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coupled_tool.h"

#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/spring_motion.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

void begin_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool) {
  if (tool.is_coupled()) {
    begin_spring(step.copy.spring_compliance(tool), lengths.inverse_dt_squared,
                 moves_vertices(step.data.options), tool.spring);
  }
}

void balance_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool) {
  if (!tool.is_coupled()) {
    return;
  }
  const MovingVertices vertices = moving_vertices(step);
  const auto add_answers = [&](const Vec3<float>& shift, VertexEnergy<float>& energy) {
    for (const SurfaceContact& contact : tool.surface_contacts) {
      add_answer(contact,
                 answer(contact, tool.surface.friction, read_contact(vertices, contact, shift),
                        lengths.inverse_dt_squared, contact.stiffness),
                 -1, energy);
    }
  };
  balance_spring(lengths.inverse_dt_squared, add_answers, tool.spring);
}

void end_coupling(const StepContext& step, ToolState& tool) {
  if (tool.is_coupled()) {
    end_spring(tool.stride(), told_way(tool), way_of(tool), step.data.part.h, tool.spring);
  }
}

}  // namespace pbdsurg
