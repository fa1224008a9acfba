// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The energy around vertices from their rows, for one vertex or for a register of them.

#include "pbdsurg/constraints/vertex_block.h"
#include "pbdsurg/core/vec3.h"

#include "solver/particle.h"
#include "solver/vertex_rows.h"

namespace pbdsurg {

/// Adds what the rows of a block tell to the energies of its vertices. Not a number, or infinite,
/// where a neighbour is.
/// @param access  load(const float*): a Scalar of stored lanes; position(const ParticleOffset*):
/// likewise
/// @param x       m, where the vertices are
template <class Access, class Scalar>
inline void add_rows(const VertexRows& rows, const VertexBlock& block, const Access& access,
                     const Vec3<Scalar>& x, VertexEnergy<Scalar>& energy) {
  const PullRow* const pulls = rows.pulls + block.pulls.first;
  for (Index i = 0; i < block.pulls.count; ++i) {
    energy.add_pull(access.load(pulls[i].weights), access.position(pulls[i].neighbors) - x);
  }
  const SpringRow* const springs = rows.springs + block.springs.first;
  for (Index i = 0; i < block.springs.count; ++i) {
    energy.add_spring(access.load(springs[i].stiffness), access.load(springs[i].rest),
                      access.position(springs[i].neighbors) - x);
  }
  const VolumeRow* const volumes = rows.volumes + block.volumes.first;
  for (Index i = 0; i < block.volumes.count; ++i) {
    energy.add_volume(access.load(volumes[i].stiffness), access.load(volumes[i].target), x,
                      access.position(volumes[i].face[0]), access.position(volumes[i].face[1]),
                      access.position(volumes[i].face[2]));
  }
}

}  // namespace pbdsurg
