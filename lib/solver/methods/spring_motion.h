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
/// @param goes_on     whether multipliers carry over from the substep before
PBDSURG_HOST_DEVICE inline void begin_spring(float compliance, float inverse_dt_squared,
                                             bool goes_on, ToolSpring& spring) {
  spring.yield = compliance * inverse_dt_squared;
  spring.shift = goes_on ? Vec3<float>{} : -1.0F * spring.displacement;
}

/// N/m, of a spring in a substep; zero of a tool that has none.
[[nodiscard]] PBDSURG_HOST_DEVICE inline float stiffness_of(const ToolSpring& spring,
                                                            float inverse_dt_squared) {
  return spring.yield > 0 ? inverse_dt_squared / spring.yield : 0;
}

/// After a sweep of vertex blocks: moves the tool to where its spring and its contacts balance,
/// with tissue where it is.
/// @param add_answers  void(shift, VertexEnergy<float>&), of the tool's contacts in their order
template <class AddAnswers>
PBDSURG_DEVICE inline void balance_spring(float inverse_dt_squared, const AddAnswers& add_answers,
                                          ToolSpring& spring) {
  constexpr int kMostPasses = 8;  // of Newton's method: contacts open and close, stick and slip
  constexpr float kSmallestMove = 1e-6F;  // of the displacement: a rounding
  const float stiffness = stiffness_of(spring, inverse_dt_squared);
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

/// After a substep: the tool is displaced by its shift, as far as that is sound. It may always stay
/// where it was. Beside that it comes back by a stride at most, and gives way by no more than that
/// beyond the way that it was moved and what the fastest tissue goes: what tissue all around it
/// does, against itself, may have any size.
/// @param stride  m, with which its axis has not passed what it meets
/// @param told    m, the way of its origin in the substep, as it was told
/// @param way     m, likewise, the longest of an end of its capsules
/// @param h       s, of the substep
PBDSURG_HOST_DEVICE inline void end_spring(float stride, const Vec3<float>& told, float way,
                                           float h, ToolSpring& spring) {
  constexpr float kFastest = 1;  // m/s, of tissue that pushes
  using std::sqrt;
  const Vec3<float> before = spring.displacement, after = before + spring.shift;
  const float told_square = dot(told, told);
  const float share = told_square > 0 ? -dot(spring.shift, told) / told_square : 0.0F;
  const Vec3<float> stays = (share < 0 ? 0.0F : (share > 1 ? -1.0F : -share)) * told;
  const Vec3<float> rest = spring.shift - stays;
  const float square = dot(rest, rest);
  const float most = dot(after, after) < dot(before, before) ? stride : stride + way + kFastest * h;
  spring.displacement =
      square > most * most ? before + stays + (most / sqrt(square)) * rest : after;
  spring.shift = {};
}

}  // namespace pbdsurg
