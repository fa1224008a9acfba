// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Stiff links of the vertex-block method on a host.

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/loose_end.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {

/// Makes a force a load of a vertex.
/// @param flight  of the vertex, see VertexState
/// @param force   N
/// @param w       1/kg
inline void push_flight(Particle& flight, const Vec3<float>& force, float w,
                        float inverse_dt_squared) {
  store(flight, load(flight) + pushed_flight(force, w, inverse_dt_squared));
}

/// How a vertex gives way, as was found.
inline LooseEnd<float> load_end(const LinkEnds& ends, ParticleOffset corner) {
  const Particle& way = at(ends.ways, corner);
  const Particle& give = at(ends.gives, corner);
  const Particle& shear = at(ends.shears, corner);
  return {{give.x, give.y, give.z, shear.x, shear.y, shear.z}, load(way), way.w};
}

/// Finds how vertices give way to their stiff links: some of a block, or those in no block.
void find_loose_ends(const StepContext& step, const VertexState& state, Index block,
                     LaneBits lanes);
void find_lone_ends(const StepContext& step, const VertexState& state);

/// From these, finds the force of each stiff link of a group, and makes it a load of its ends.
void begin_joints(const StepContext& step, const VertexState& state, Index group);

}  // namespace pbdsurg
