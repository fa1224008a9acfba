// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a stiff link starts in a substep of the vertex-block method: see constraints/stiff_link.h.
/// On a CPU or a device.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/stiff_link.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/methods/vertex_rows.h"

namespace pbdsurg {

/// An end of a stiff link that may go where it likes.
struct LooseEnd {
  VertexGive<float> give;  ///< nothing, where the end cannot move
  Vec3<float> way;         ///< m, to the least energy of the vertex
  bool is_lost = false;    ///< whether nobody knows where it is
};

/// @param start  the energy of the vertex without rows
/// @param holds  of the vertex, see move_held()
template <class Access, class Holds>
PBDSURG_DEVICE inline LooseEnd loose_end(const VertexRows& rows, const VertexBlock& block,
                                         const Access& access, const VertexEnergy<float>& start,
                                         const Holds& holds) {
  VertexEnergy<float> energy = start;
  add_rows(rows, block, access, energy);
  if (!is_finite_way(energy.force)) {
    energy = start;
    add_finite_rows(rows, block, access, energy);
  }
  const RigidGrasps rigid = add_grasps(holds, energy);
  if (rigid.count > 0) {
    return {{}, (1 / static_cast<float>(rigid.count)) * rigid.targets};
  }
  const VertexFactor<float> factor(energy);
  const LooseEnd end{VertexGive<float>::of(factor), factor.solve(energy.force)};
  return is_finite_way(end.way) ? end : LooseEnd{};
}

/// A link at the start of the sweeps: its force is what holds both ends where they are, as long as
/// all else stays. Nothing holds an end that is lost.
/// @param d  m, from the first end to the other
PBDSURG_HOST_DEVICE inline StiffLinkConstraint::Joint<float> begin_joint(const LooseEnd& first,
                                                                         const LooseEnd& other,
                                                                         const Vec3<float>& d,
                                                                         float rest,
                                                                         float compliance) {
  if (first.is_lost || other.is_lost) {
    return {};
  }
  StiffLinkConstraint::Joint<float> joint{{}, {first.give, other.give}};
  joint.force = StiffLinkConstraint::force(joint, d + (other.way - first.way), rest, compliance);
  return joint;
}

}  // namespace pbdsurg
