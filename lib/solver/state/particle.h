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

/// @tparam Quad  a particle, or what an array as wide has of it
template <class Quad>
PBDSURG_HOST_DEVICE inline Quad& at(Quad* quads, ParticleOffset offset) {
  static_assert(sizeof(Quad) == sizeof(Particle));
  return *reinterpret_cast<Quad*>(reinterpret_cast<char*>(quads) + offset);
}
template <class Quad>
PBDSURG_HOST_DEVICE inline const Quad& at(const Quad* quads, ParticleOffset offset) {
  static_assert(sizeof(Quad) == sizeof(Particle));
  return *reinterpret_cast<const Quad*>(reinterpret_cast<const char*>(quads) + offset);
}

/// Velocity of a vertex, as wide as a particle.
struct alignas(16) Velocity {
  float x = 0, y = 0, z = 0;  ///< m/s
  float unused = 0;
};

/// What a vertex takes from substep to substep beside position and velocity, as wide as a particle.
struct alignas(16) Carry {
  float x = 0, y = 0, z = 0;  ///< m, what its position lacks by rounding
  float falling = 1;          ///< in [0, 1], the share of gravity with which it last sped up
};

/// What acts on a vertex from outside, as wide as a particle.
struct alignas(16) Load {
  float x = 0, y = 0, z = 0;  ///< N of a force, m/s^2 of a gravity
  float inverse_square = 0;   ///< s^4/m^2, of a gravity that is not zero
};

/// What BDF2 remembers of the substep before, as wide as a particle each; see displacement.h.
struct alignas(16) Way {
  float x = 0, y = 0, z = 0;  ///< m, that a vertex went in it
  float unused = 0;
};

/// What a vertex does, without its mass.
struct VertexMotion {
  float x, y, z;  ///< m
  Velocity velocity;
  Carry carry;               ///< as new in fraction mode, which has none
  Way way;                   ///< of BDF2, else as new
  Velocity velocity_before;  ///< likewise
};

}  // namespace pbdsurg
