// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One lane of blocks, for templates that run on registers of lanes as well.

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/load_store.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// @tparam Quad  of displacements or roundings
template <class Quad>
struct LaneAccess {
  using Scalar = float;

  const Particle* bases;
  const Quad* moving;
  Vec3<float> own_base;  ///< m, from where positions count
  Index lane;

  LaneAccess(const Particle* from, const Quad* quads, ParticleOffset own, Index which)
      : bases(from), moving(quads), own_base(pbdsurg::load(at(from, own))), lane(which) {}

  [[nodiscard]] float load(const float* numbers) const noexcept { return numbers[lane]; }
  void store(float number, float* numbers) const noexcept { numbers[lane] = number; }
  [[nodiscard]] Vec3<float> position(const ParticleOffset* corners) const noexcept {
    return (pbdsurg::load(at(bases, corners[lane])) - own_base) +
           pbdsurg::load(at(moving, corners[lane]));
  }
};

}  // namespace pbdsurg
