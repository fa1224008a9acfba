// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where stiff links start in a substep of the vertex-block method: see constraints/stiff_link.h.
/// First it is found how their ends give way, once for each, then the force of one link after
/// another. Of one vertex or a register of them, on a CPU or a device.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/stiff_link.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/methods/vertex_rows.h"

namespace pbdsurg {

/// An end of stiff links that may go where it likes.
template <class Scalar>
struct LooseEnd {
  VertexGive<Scalar> give;  ///< nothing, where the end cannot move
  Vec3<Scalar> way;         ///< m, to the least energy of the vertex under the forces of its links
  Scalar is_known{1};       ///< 1; 0 where nobody knows where it is

  /// Of a vertex with this energy, whose rows are added.
  PBDSURG_HOST_DEVICE static LooseEnd of(const VertexEnergy<Scalar>& energy) {
    const VertexFactor<Scalar> factor(energy);
    return {VertexGive<Scalar>::of(factor), factor.solve(energy.force)};
  }

  /// Gives way to the force of a link, N.
  PBDSURG_HOST_DEVICE void push(const Vec3<Scalar>& force) { way = way + give * force; }
};

/// @param energy  of the vertex, see finite_energy()
/// @param holds   of the vertex, see move_held()
template <class Holds>
PBDSURG_DEVICE inline LooseEnd<float> find_loose_end(VertexEnergy<float> energy,
                                                     const Holds& holds) {
  const RigidGrasps rigid = add_grasps(holds, energy);
  if (rigid.count > 0) {
    return {{}, (1 / static_cast<float>(rigid.count)) * rigid.targets};
  }
  const LooseEnd<float> end = LooseEnd<float>::of(energy);
  return is_finite_way(end.way) ? end : LooseEnd<float>{};
}

/// A link at the start of the sweeps: its force is what holds both ends where they are, as long as
/// all else stays. Nothing holds an end that is lost.
/// @param d  m, from the first end to the other
template <class Scalar>
PBDSURG_HOST_DEVICE inline StiffLinkConstraint::Joint<Scalar> begin_joint(
    const LooseEnd<Scalar>& first, const LooseEnd<Scalar>& other, const Vec3<Scalar>& d,
    Scalar rest, Scalar compliance) {
  const auto is_known = (first.is_known > Scalar(0)) & (other.is_known > Scalar(0));
  StiffLinkConstraint::Joint<Scalar> joint{{}, {first.give, other.give}};
  const Vec3<Scalar> force =
      StiffLinkConstraint::force(joint, d + (other.way - first.way), rest, compliance);
  joint.force = select(is_known, force, Vec3<Scalar>{});
  for (VertexGive<Scalar>& give : joint.give) {
    for (Scalar* const number : {&give.xx, &give.yy, &give.zz, &give.xy, &give.xz, &give.yz}) {
      *number = select(is_known, *number, Scalar(0));
    }
  }
  return joint;
}

}  // namespace pbdsurg
