// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One lane of blocks, for templates that run on registers of lanes as well.

#include "pbdsurg/core/types.h"
#include "pbdsurg/core/vec3.h"

#include "solver/load_store.h"
#include "solver/particle.h"

namespace pbdsurg {

struct LaneAccess {
  using Scalar = float;

  const Particle* particles;
  Index lane;

  [[nodiscard]] float load(const float* numbers) const noexcept { return numbers[lane]; }
  void store(float number, float* numbers) const noexcept { numbers[lane] = number; }
  [[nodiscard]] Vec3<float> position(const ParticleOffset* corners) const noexcept {
    return pbdsurg::load(at(particles, corners[lane]));
  }
};

}  // namespace pbdsurg
