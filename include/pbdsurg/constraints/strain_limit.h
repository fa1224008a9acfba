// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps an edge from getting longer than its tissue can bear.
///
///     x0 o-----------o x1      C = |x0 - x1| - limit <= 0       m
///                              gradient  +n at x0, -n at x1     1
///                              compliance                       0: rigid, in both modes
///                              multiplier                       none: it pulls when too long,
///                                                               and gives nothing back

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps an edge from getting longer than a limit: constraints/strain_limit.h has the equations.
struct StrainLimitConstraint : InPlace<StrainLimitConstraint> {
  static constexpr int kVertexCount = 2;      ///< vertices of one constraint
  static constexpr int kMultiplierCount = 1;  ///< none: it stays zero
  /// What one constraint stores.
  enum Parameter {
    kLimit,          ///< m
    kParameterCount  ///< how many these are
  };

  /// One projection.
  ///
  /// @param x  m
  /// @param w  1/kg, zero for a fixed vertex
  /// @return   m
  template <ProjectionMode, class Scalar, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static Moves<Scalar, 2> move(const Vec3<Scalar> (&x)[2], const Scalar (&w)[2],
                                                   const Scalar (&parameters)[kParameterCount],
                                                   const Substep<Scalar>&,
                                                   Scalar (&)[kMultiplierCount],
                                                   const Damping& = {}) {
    using std::sqrt;
    const Vec3<Scalar> d = x[0] - x[1];
    const Scalar length = sqrt(dot(d, d));
    const Scalar mobility = w[0] + w[1];
    const auto is_pulled = (length > parameters[kLimit]) & is_usable(length) & is_usable(mobility);
    const Vec3<Scalar> along = select(
        is_pulled, ((parameters[kLimit] - length) / (mobility * length)) * d, Vec3<Scalar>{});
    return {{w[0] * along, -w[1] * along}};
  }
};

}  // namespace pbdsurg
