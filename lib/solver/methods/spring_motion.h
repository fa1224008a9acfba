// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a substep does to the spring of a coupled tool, on a CPU or a device: see coupled_tool.h.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/tool_spring.h"

namespace pbdsurg {

/// Before contacts are met: projections have no multipliers yet, so the tool is where it is to be;
/// vertex blocks go on from those of the substep before.
/// @param compliance  m/N
/// @param goes_on     whether these do
PBDSURG_HOST_DEVICE inline void begin_spring(float compliance, float inverse_dt_squared,
                                             bool goes_on, ToolSpring& spring) {
  spring.yield = compliance * inverse_dt_squared;
  spring.shift = goes_on ? Vec3<float>{} : -1.0F * spring.displacement;
}

/// After a sweep of vertex blocks: moves the tool to where its spring and its contacts balance,
/// with tissue where it is.
/// @param add_answers  void(shift, VertexEnergy<float>&), of the tool's contacts in their order
template <class AddAnswers>
PBDSURG_DEVICE inline void balance_spring(float inverse_dt_squared, const AddAnswers& add_answers,
                                          ToolSpring& spring) {
  constexpr int kMostPasses = 8;  // of Newton's method: contacts open and close, stick and slip
  constexpr float kSmallestMove = 1e-6F;                      // of the displacement: a rounding
  const float stiffness = inverse_dt_squared / spring.yield;  // N/m
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const Vec3<float> displacement = spring.displacement + spring.shift;
    VertexEnergy<float> energy;
    energy.add_pull(stiffness, -1.0F * displacement);
    add_answers(spring.shift, energy);
    const Vec3<float> move = VertexFactor<float>(energy).solve(energy.force);
    if (!is_finite_way(move)) {
      return;
    }
    spring.shift = spring.shift + move;
    if (dot(move, move) <= kSmallestMove * kSmallestMove * dot(displacement, displacement)) {
      return;
    }
  }
}

/// After a substep: the tool is displaced by its shift.
/// @param stride  m, by how much it may come back: its axis then has not passed what it meets
PBDSURG_HOST_DEVICE inline void end_spring(float stride, ToolSpring& spring) {
  using std::sqrt;
  const Vec3<float> before = spring.displacement, after = before + spring.shift;
  const float square = dot(spring.shift, spring.shift);
  const bool leaps_back = dot(after, after) < dot(before, before) && square > stride * stride;
  spring.displacement = leaps_back ? before + (stride / sqrt(square)) * spring.shift : after;
  spring.shift = {};
}

}  // namespace pbdsurg
