// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_yield.h"

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/loose_end.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

VertexGive<float> find_give(const StepContext& step, const VertexState& state, Index place) {
  const auto [block_index, lane] = step.data.vertex_blocks.place_of(place);
  const Particle& p = state.displacements[place];
  if (block_index == kInvalidIndex || !(p.w > 0) || is_lost(state.fixed_points[place])) {
    return {};
  }
  const VertexRows rows = vertex_rows(step);
  VertexEnergy<float> start;
  start.add_pull(state.inverse_dt_squared / p.w, load(state.flights[place]) - load(p));
  const LaneAccess access{state.fixed_points, state.fixed_points[place], lane};
  const HeldVertex held(step, {load(state.bases[place]), load(p)}, step.scratch.first_holds[place]);
  return find_loose_end(finite_energy(rows, rows.blocks[block_index], access, start), held).give;
}

}  // namespace

float yield_of(const StepContext& step, const VertexState& state, Index place,
               const Vec3<float>& direction) {
  const Index first = step.scratch.first_holds[place];
  if (first == kInvalidIndex) {
    return 0;  // fixed
  }
  HeldGive& known = step.scratch.gives[first];
  if (!known.is_known) {
    known = {find_give(step, state, place), true};
  }
  return dot(direction, known.give * direction);
}

}  // namespace pbdsurg
