// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A motion in double precision, without a solver of the library: velocity Verlet (Verlet 1967;
/// Hairer, Lubich, Wanner 2003, "Geometric Numerical Integration Illustrated by the Stoermer-Verlet
/// Method").

#include "pbdsurg/tissue/scene.h"

#include "bench/support/static_energy.h"

namespace pbdsurg::bench {

struct Motion {
  Positions x;  // m
  Positions v;  // m/s
};

/// @param scene    of Neo-Hookean bodies
/// @param start    m, at rest
/// @param substep  s, so short that this is stable
[[nodiscard]] Motion integrate(const Scene& scene, const Positions& start, double seconds,
                               double substep);

/// Kinetic, elastic and of the weight, J.
[[nodiscard]] double total_energy(const Scene& scene, const Motion& motion);

}  // namespace pbdsurg::bench
