// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One lane of blocks, for templates that run on registers of lanes as well.

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/load_store.h"
#include "lib/solver/state/particle.h"

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
