// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One lane of blocks, for templates that run on registers of lanes as well.

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// Within sweeps.
struct LaneAccess {
  using Scalar = float;

  const FixedPoint* fixed_points;
  const FixedPoint& own;  ///< of the lane's vertex, from where positions count
  Index lane;

  [[nodiscard]] float load(const float* numbers) const noexcept { return numbers[lane]; }
  [[nodiscard]] Vec3<float> position(const ParticleOffset* corners) const noexcept {
    const FixedPoint& point = at(fixed_points, corners[lane]);
    return fixed_difference<float, std::uint32_t>({point.x, point.y, point.z},
                                                  {own.x, own.y, own.z}, point.unit);
  }
};

/// Where vertices are heading for: see StableSubstep.
struct HeadingAccess {
  using Scalar = float;

  const Particle* bases;
  const Velocity* velocities;
  Vec3<float> own_base;  ///< m
  float time;            ///< s
  Index lane;

  [[nodiscard]] float load(const float* numbers) const noexcept { return numbers[lane]; }
  [[nodiscard]] Heading<float> position(const ParticleOffset* corners) const noexcept {
    return {pbdsurg::load(at(bases, corners[lane])) - own_base,
            time * pbdsurg::load(at(velocities, corners[lane]))};
  }
};

/// At the start of a substep.
struct StartAccess {
  using Scalar = float;

  const Particle* bases;
  const Carry* carries;
  Vec3<float> own_base;  ///< m
  Index lane;

  [[nodiscard]] float load(const float* numbers) const noexcept { return numbers[lane]; }
  void store(float number, float* numbers) const noexcept { numbers[lane] = number; }
  [[nodiscard]] Vec3<float> position(const ParticleOffset* corners) const noexcept {
    return (pbdsurg::load(at(bases, corners[lane])) - own_base) +
           pbdsurg::load(at(carries, corners[lane]));
  }
};

}  // namespace pbdsurg
