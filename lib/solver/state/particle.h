// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vertices as the solver stores them.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Position and inverse mass of a vertex: one 16-byte load.
struct alignas(16) Particle {
  float x, y, z;  ///< m
  float w;        ///< 1/kg, zero when it cannot move
};

/// Where the particle at a place of the state starts in an array of them, in bytes. Constraints
/// name vertices so, because it spares kernels two instructions a corner, a tenth of their time.
using ParticleOffset = std::uint32_t;

/// The most vertices that offsets reach.
inline constexpr Index kMostParticles = Index{1} << 28;

PBDSURG_HOST_DEVICE inline ParticleOffset offset_of(Index place) {
  return static_cast<ParticleOffset>(place) * sizeof(Particle);
}
PBDSURG_HOST_DEVICE inline Index place_at(ParticleOffset offset) {
  return static_cast<Index>(offset / sizeof(Particle));
}

PBDSURG_HOST_DEVICE inline Particle& at(Particle* particles, ParticleOffset offset) {
  return *reinterpret_cast<Particle*>(reinterpret_cast<char*>(particles) + offset);
}
PBDSURG_HOST_DEVICE inline const Particle& at(const Particle* particles, ParticleOffset offset) {
  return *reinterpret_cast<const Particle*>(reinterpret_cast<const char*>(particles) + offset);
}

/// Velocity of a vertex, as wide as a particle.
struct alignas(16) Velocity {
  float x = 0, y = 0, z = 0;  ///< m/s
  float unused = 0;
};

/// What a vertex does, without its mass.
struct VertexMotion {
  float x, y, z;  ///< m
  Velocity velocity;
  float falling;  ///< of the vertex-block method, see Snapshot; else zero
};

}  // namespace pbdsurg
