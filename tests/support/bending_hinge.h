// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hinges bent to a given angle.

#include <cmath>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/bending.h"

namespace pbdsurg::testing {

inline constexpr double kPi = 3.14159265358979323846;

template <class Scalar = double>
struct Hinge {
  Vec3<Scalar> x[4];
  Scalar w[4] = {1, 1, 1, 1};

  // Two triangles of unlike heights in units of `edge`, bent by `angle` about their common edge.
  Hinge(double edge, double angle) {
    const double tilt = 0.3;  // no axis is special
    const auto place = [&](int i, double along, double out, double turn) {
      const double y = out * std::cos(turn), z = -std::abs(out) * std::sin(turn);
      x[i] = {static_cast<Scalar>(edge * along),
              static_cast<Scalar>(edge * (y * std::cos(tilt) - z * std::sin(tilt))),
              static_cast<Scalar>(edge * (y * std::sin(tilt) + z * std::cos(tilt)))};
    };
    place(0, 0, 0, 0);
    place(1, 1.1, 0, 0);
    place(2, 0.4, 0.9, 0.3 * angle);
    place(3, 0.8, -0.6, 0.7 * angle);
  }

  [[nodiscard]] double value(double rest = 0) const {
    return BendingConstraint::value(x, static_cast<Scalar>(rest));
  }

  template <ProjectionMode kMode>
  Scalar project(double rest, double stiffness) {
    const Scalar parameters[] = {static_cast<Scalar>(rest), static_cast<Scalar>(stiffness), 0};
    Scalar multiplier[] = {0};
    BendingConstraint::project<kMode>(x, w, parameters, Substep<Scalar>{1, 1}, multiplier);
    return multiplier[0];
  }

  [[nodiscard]] bool is_same_as(const Hinge& other) const {
    bool same = true;
    for (int i = 0; i < 4; ++i) {
      same = same && x[i].x == other.x[i].x && x[i].y == other.x[i].y && x[i].z == other.x[i].z;
    }
    return same;
  }
};

inline double turn_of(double angle) {
  return 4 * std::tan(angle / 4);
}

inline Vec3<double> random_point(double size, std::uint64_t seed, int i) {
  return {size * (2 * random_unit(seed, i, 0) - 1), size * (2 * random_unit(seed, i, 1) - 1),
          size * (2 * random_unit(seed, i, 2) - 1)};
}

}  // namespace pbdsurg::testing
