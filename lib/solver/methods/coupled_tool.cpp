// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coupled_tool.h"

#include <algorithm>
#include <cmath>

#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

constexpr int kMostPasses = 8;  // of Newton's method: contacts open and close, stick and slip
constexpr float kSmallestMove = 1e-6F;  // of the displacement: a rounding

// m, by how much a tool may come back in a substep: its axis then has not passed what it meets.
float stride_of(const ToolState& tool) {
  float least = kInfinity;
  for (const Capsule& capsule : tool.capsules) {
    least = std::min(least, capsule.radius);
  }
  return least / 2;
}

}  // namespace

void begin_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool) {
  if (!tool.is_coupled()) {
    return;
  }
  // forces are in units of the copy: see substep_numbers()
  const float compliance = step.copy.factors.stiffness / tool.coupling.stiffness;
  tool.yield = compliance * lengths.inverse_dt_squared;
  tool.shift = moves_vertices(step.data.options) ? Vector{} : -1.0F * load(tool.displacement);
}

void balance_coupling(const StepContext& step, const Substep<float>& lengths, ToolState& tool) {
  if (!tool.is_coupled()) {
    return;
  }
  const MovingVertices vertices = moving_vertices(step);
  const float stiffness = lengths.inverse_dt_squared / tool.yield;  // N/m
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const Vector displacement = load(tool.displacement) + tool.shift;
    VertexEnergy<float> energy;
    energy.add_pull(stiffness, -1.0F * displacement);
    for (const SurfaceContact& contact : tool.surface_contacts) {
      add_answer(contact,
                 answer(contact, tool.surface.friction, read_contact(vertices, contact, tool),
                        lengths.inverse_dt_squared, contact.stiffness),
                 -1, energy);
    }
    const Vector move = VertexFactor<float>(energy).solve(energy.force);
    if (!is_finite_way(move)) {
      return;
    }
    tool.shift = tool.shift + move;
    if (dot(move, move) <= kSmallestMove * kSmallestMove * dot(displacement, displacement)) {
      return;
    }
  }
}

void end_coupling(ToolState& tool) {
  if (!tool.is_coupled()) {
    return;
  }
  const Vector before = load(tool.displacement);
  const Vector after = before + tool.shift;
  const float square = dot(tool.shift, tool.shift), stride = stride_of(tool);
  const bool leaps_back = dot(after, after) < dot(before, before) && square > stride * stride;
  tool.displacement =
      vector_of(leaps_back ? before + (stride / std::sqrt(square)) * tool.shift : after);
  tool.shift = {};
}

}  // namespace pbdsurg
