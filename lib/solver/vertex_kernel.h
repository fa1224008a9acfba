// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The energy around vertices from their rows, for one vertex or for a register of them.

#include <limits>

#include "pbdsurg/constraints/vertex_block.h"
#include "pbdsurg/core/vec3.h"

#include "solver/particle.h"
#include "solver/vertex_rows.h"

namespace pbdsurg {

/// Adds what the rows of a block tell to the energies of its vertices. Not a number or infinite
/// where a neighbour is: see add_finite_rows().
/// @param access  load(const float*): a Scalar of stored lanes; position(const Index*): likewise
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
                      access.position(volumes[i].vertices[0]),
                      access.position(volumes[i].vertices[1]),
                      access.position(volumes[i].vertices[2]));
  }
}

/// One lane of a block.
struct LaneAccess {
  const Particle* particles;
  Index lane;

  [[nodiscard]] float load(const float* values) const noexcept { return values[lane]; }
  [[nodiscard]] Vec3<float> position(const Index* vertices) const noexcept {
    const Particle& p = particles[vertices[lane]];
    return {p.x, p.y, p.z};
  }
};

/// Whether a displacement is finite, and so is its length.
inline bool is_finite(const Vec3<float>& d) {
  return dot(d, d) <= std::numeric_limits<float>::max();
}

/// As add_rows(), of one vertex, without the rows that lead to what is not finite. A neighbour may
/// be lost, but not the definiteness of the Hessian: negative pulls stay out, too.
inline void add_finite_rows(const VertexRows& rows, const VertexBlock& block,
                            const LaneAccess& access, const Vec3<float>& x,
                            VertexEnergy<float>& energy) {
  const PullRow* const pulls = rows.pulls + block.pulls.first;
  for (Index i = 0; i < block.pulls.count; ++i) {
    const Vec3<float> d = access.position(pulls[i].neighbors) - x;
    const float weight = access.load(pulls[i].weights);
    if (is_finite(d) && weight > 0) {
      energy.add_pull(weight, d);
    }
  }
  const SpringRow* const springs = rows.springs + block.springs.first;
  for (Index i = 0; i < block.springs.count; ++i) {
    const Vec3<float> d = access.position(springs[i].neighbors) - x;
    if (is_finite(d)) {
      energy.add_spring(access.load(springs[i].stiffness), access.load(springs[i].rest), d);
    }
  }
  const VolumeRow* const volumes = rows.volumes + block.volumes.first;
  for (Index i = 0; i < block.volumes.count; ++i) {
    const Vec3<float> a = access.position(volumes[i].vertices[0]);
    const Vec3<float> b = access.position(volumes[i].vertices[1]);
    const Vec3<float> c = access.position(volumes[i].vertices[2]);
    if (is_finite(a - x) && is_finite(b - x) && is_finite(c - x)) {
      energy.add_volume(access.load(volumes[i].stiffness), access.load(volumes[i].target), x, a, b,
                        c);
    }
  }
}

}  // namespace pbdsurg
