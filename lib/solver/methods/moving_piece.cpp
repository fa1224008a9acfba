// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/moving_piece.h"

#include <array>

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {

MovingPiece::MovingPiece(const StepContext& step, Index piece, const PushedPieces* groups)
    : step_(step), piece_(piece), groups_(groups), is_from_end_(has_past(step.data.options)) {}

bool MovingPiece::counts(Index place) const {
  const Particle& p = step_.scratch.displacements[place];
  return keeps_momentum(p.w, load(step_.copy.particles[place]), load(p),
                        load(step_.scratch.flights[place]));
}

Vec3<double> MovingPiece::arm(Index place) const {
  return arm_of(load(step_.copy.particles[place]), load(step_.scratch.displacements[place]),
                is_from_end_);
}

MomentumSums MovingPiece::momentum() const {
  std::array<MomentumSums, kMomentumSums> sums;
  std::size_t i = 0;
  for_each_place([&](Index place) {
    MomentumSums& sum = sums[i++ % kMomentumSums];
    const Particle& p = step_.scratch.displacements[place];
    if (counts(place)) {
      sum.add(1 / static_cast<double>(p.w), arm(place),
              to_double(load(p) - load(step_.scratch.flights[place])));
    }
  });
  return total(sums);
}

}  // namespace pbdsurg
