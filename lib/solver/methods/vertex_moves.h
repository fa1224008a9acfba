// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How one vertex of the vertex-block method moves, with all that may happen to it: neighbours that
/// are lost, tools that touch or hold it. On a CPU or a device.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_rows.h"

namespace pbdsurg {

/// Whether a displacement is finite, and so is its square.
PBDSURG_HOST_DEVICE inline bool is_finite_way(const Vec3<float>& d) {
  return dot(d, d) < kInfinity;
}

/// As add_rows(), of one vertex, without the rows that lead to what is not finite. A neighbour may
/// be lost, but not the definiteness of the Hessian: negative pulls stay out, too.
template <class Access, class Energy>
PBDSURG_DEVICE inline void add_finite_rows(const VertexRows& rows, const VertexBlock& block,
                                           const Access& access, Energy& energy) {
  const PullRow* const pulls = rows.pulls + block.pulls.first;
  for (Index i = 0; i < block.pulls.count; ++i) {
    const Vec3<float> d = access.position(pulls[i].neighbors);
    const float weight = access.load(pulls[i].weights);
    if (is_finite_way(d) && weight > 0) {
      energy.add_pull(weight, d);
    }
  }
  const SpringRow* const springs = rows.springs + block.springs.first;
  for (Index i = 0; i < block.springs.count; ++i) {
    const Vec3<float> d = access.position(springs[i].neighbors);
    if (is_finite_way(d)) {
      energy.add_spring(access.load(springs[i].stiffness), access.load(springs[i].rest), d);
    }
  }
  const VolumeRow* const volumes = rows.volumes + block.volumes.first;
  for (Index i = 0; i < block.volumes.count; ++i) {
    const Vec3<float> a = access.position(volumes[i].face[0]);
    const Vec3<float> b = access.position(volumes[i].face[1]);
    const Vec3<float> c = access.position(volumes[i].face[2]);
    if (is_finite_way(a) && is_finite_way(b) && is_finite_way(c)) {
      energy.add_volume(access.load(volumes[i].stiffness), access.load(volumes[i].target), a, b, c);
    }
  }
  const HingeRow* const hinges = rows.hinges + block.hinges.first;
  for (Index i = 0; i < block.hinges.count; ++i) {
    const Vec3<float> a = access.position(hinges[i].neighbors[0]);
    const Vec3<float> b = access.position(hinges[i].neighbors[1]);
    const Vec3<float> c = access.position(hinges[i].neighbors[2]);
    if (is_finite_way(a) && is_finite_way(b) && is_finite_way(c)) {
      add_hinge(hinges[i], block, access, a, b, c, energy);
    }
  }
  const TriangleRow* const triangles = rows.triangles + block.triangles.first;
  for (Index i = 0; i < block.triangles.count; ++i) {
    const Vec3<float> a = access.position(triangles[i].neighbors[0]);
    const Vec3<float> b = access.position(triangles[i].neighbors[1]);
    if (is_finite_way(a) && is_finite_way(b)) {
      energy.add_triangle(access.load(triangles[i].weights[0]),
                          access.load(triangles[i].weights[1]), access.load(triangles[i].stiffness),
                          access.load(triangles[i].target), a, b);
    }
  }
  const FibreRow* const fibres = rows.fibres + block.fibres.first;
  for (Index i = 0; i < block.fibres.count; ++i) {
    const RowFibre<float> fibre(fibres[i], access);
    if (is_finite_way(fibre.stretched)) {
      energy.add_fibre(access.load(fibres[i].stiffness), fibre.share, fibre.stretched);
    }
  }
}

/// Where a vertex is: the sum of both would round.
struct SplitPosition {
  Vec3<float> base;          ///< m, at the start of the substep
  Vec3<float> displacement;  ///< m, since then

  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> way_to(const Vec3<float>& target) const {
    return (target - base) - displacement;
  }
  /// @param offset  m, of a plane
  [[nodiscard]] PBDSURG_HOST_DEVICE float height_to(const Vec3<float>& normal, float offset) const {
    return (offset - dot(normal, base)) - dot(normal, displacement);
  }
};

/// Whether a grasp is a spring.
/// @param stiffness  N/m
PBDSURG_HOST_DEVICE inline bool is_soft_grasp(float stiffness) {
  using std::fabs;
  return fabs(stiffness) < kInfinity;
}

/// Passes over several contacts at one vertex, each pushing no more than the others leave to it.
inline constexpr int kContactPasses = 8;

/// Where tools want a vertex that they hold rigidly.
struct RigidGrasps {
  int count = 0;
  Vec3<float> targets;  ///< m, their sum, from the vertex
};

/// Adds the soft grasps of a vertex to its energy.
/// @param holds  as in move_held()
/// @return       the others
template <class Holds>
PBDSURG_DEVICE inline RigidGrasps add_grasps(const Holds& holds, VertexEnergy<float>& energy) {
  RigidGrasps rigid;
  holds.for_each_grasp([&](const auto& grasp) {
    const float stiffness = 1 / grasp.compliance();
    if (is_soft_grasp(stiffness)) {
      energy.add_pull(stiffness, grasp.target());
    } else {
      rigid.targets = rigid.targets + grasp.target();
      ++rigid.count;
    }
  });
  return rigid;
}

/// By how much a vertex moves that tools touch or hold. Grasps are springs, or where the vertex is:
/// between the targets if several tools hold it rigidly, which share the force. Contacts are planes
/// that it may not cross, if no grasp takes it there.
///
/// @param holds       of the vertex, the later of them first, in two lists:
///                    for_each_grasp() visits {target(): m, compliance(): m/N, set_multiplier()},
///                    for_each_contact() visits {normal(), offset(): m, multiplier(): kg m,
///                    set_multiplier()}
///                    targets and offsets count from where the vertex is
/// @param dt_squared  s^2
/// @return            m
template <class Holds>
PBDSURG_DEVICE inline Vec3<float> move_held(const Holds& holds, VertexEnergy<float> energy,
                                            float dt_squared) {
  int contact_count = 0;
  holds.for_each_contact([&](const auto& contact) {
    contact.set_multiplier(0);
    ++contact_count;
  });

  const RigidGrasps rigid = add_grasps(holds, energy);
  Vec3<float> target;
  Vec3<float> rigid_force;
  if (rigid.count > 0) {
    const float share = 1 / static_cast<float>(rigid.count);
    target = share * rigid.targets;
    rigid_force = share * (energy * target - energy.force);
  } else {
    const VertexFactor<float> factor(energy);
    Vec3<float> move = factor.solve(energy.force);
    for (int pass = 0; pass < (contact_count > 1 ? kContactPasses : contact_count); ++pass) {
      holds.for_each_contact([&](const auto& contact) {
        const Vec3<float> n = contact.normal();
        const Vec3<float> given = factor.solve(n);
        const float depth = contact.offset() - dot(n, move);
        const float before = contact.multiplier();
        const float pushed = before + depth / dot(n, given);
        const float force = pushed > 0 ? pushed : 0.0F;
        move = move + (force - before) * given;
        contact.set_multiplier(force);
      });
    }
    holds.for_each_contact(
        [&](const auto& contact) { contact.set_multiplier(contact.multiplier() * dt_squared); });
    target = move;
  }
  holds.for_each_grasp([&](const auto& grasp) {
    const float stiffness = 1 / grasp.compliance();
    grasp.set_multiplier(dt_squared * (is_soft_grasp(stiffness)
                                           ? stiffness * (grasp.target() - target)
                                           : rigid_force));
  });
  return target;
}

/// By how much a vertex moves, m; not at all if that is nowhere.
/// @param start   its energy without rows
/// @param energy  with them
/// @param solve   by how much a vertex moves that has an energy, m
template <class Access, class Solve>
PBDSURG_DEVICE inline Vec3<float> move_vertex(const VertexRows& rows, const VertexBlock& block,
                                              const Access& access,
                                              const VertexEnergy<float>& start,
                                              VertexEnergy<float> energy, const Solve& solve) {
  Vec3<float> move = solve(energy);
  // where a rigid grasp takes a vertex is finite, whatever its neighbours pull it with
  if (!is_finite_way(move) || !is_finite_way(energy.force)) {
    energy = start;
    add_finite_rows(rows, block, access, energy);
    move = solve(energy);
  }
  return is_finite_way(move) ? move : Vec3<float>{};
}

/// The same, of a vertex whose rows nobody has added yet.
template <class Access, class Solve>
PBDSURG_DEVICE inline Vec3<float> move_vertex(const VertexRows& rows, const VertexBlock& block,
                                              const Access& access,
                                              const VertexEnergy<float>& start,
                                              const Solve& solve) {
  VertexEnergy<float> energy = start;
  add_tree(rows, block, access, energy);
  return move_vertex(rows, block, access, start, energy, solve);
}

/// The energy of a vertex: of finite rows alone, if not all are.
/// @param start   without rows
/// @param energy  with them
template <class Access>
PBDSURG_DEVICE inline VertexEnergy<float> finite_energy(const VertexRows& rows,
                                                        const VertexBlock& block,
                                                        const Access& access,
                                                        const VertexEnergy<float>& start,
                                                        VertexEnergy<float> energy) {
  if (!is_finite_way(energy.force)) {
    energy = start;
    add_finite_rows(rows, block, access, energy);
  }
  return energy;
}

/// The same, of a vertex whose rows nobody has added yet.
template <class Access>
PBDSURG_DEVICE inline VertexEnergy<float> finite_energy(const VertexRows& rows,
                                                        const VertexBlock& block,
                                                        const Access& access,
                                                        const VertexEnergy<float>& start) {
  VertexEnergy<float> energy = start;
  add_tree(rows, block, access, energy);
  return finite_energy(rows, block, access, start, energy);
}

/// N, on a vertex where a substep starts; of what is finite, if not all is.
/// @param force  the sum of its rows
template <class Access>
PBDSURG_DEVICE inline Vec3<float> finite_force(const VertexRows& rows, const VertexBlock& block,
                                               const Access& access, VertexForce<float> force) {
  if (!is_finite_way(force.force)) {
    force = {};
    add_finite_rows(rows, block, access, force);
  }
  return force.force;
}

/// The energy of a vertex that tools touch or hold, in an explicit step: its neighbours pull it
/// with the force of the start, wherever it goes.
/// @param way     m, from where the vertex is to where it flies by itself
/// @param force   N
/// @param weight  N/m, mass over the square of the substep
PBDSURG_DEVICE inline VertexEnergy<float> pushed_energy(const Vec3<float>& way,
                                                        const Vec3<float>& force, float weight) {
  VertexEnergy<float> energy;
  energy.add_pull(weight, way);
  energy.force = energy.force + force;
  return energy;
}

}  // namespace pbdsurg
