// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vertices as the solver stores them.

namespace pbdsurg {

/// Position and inverse mass of a vertex: one 16-byte load.
struct alignas(16) Particle {
  float x, y, z;  ///< m
  float w;        ///< 1/kg, zero when it cannot move
};

/// Velocity of a vertex, as wide as a particle.
struct alignas(16) Velocity {
  float x = 0, y = 0, z = 0;  ///< m/s
  float unused = 0;
};

}  // namespace pbdsurg
