// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far sweeps are from what they solve.

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Of one body in one substep of length h. The implicit residual of a vertex of mass m,
///
///     r = m / h^2 (y - x) + f(x)
///
/// is zero where the substep is solved: y is where the vertex flies without forces but gravity, x
/// where the sweeps leave it, and f the force there of tissue, links, hinges and inner friction.
///
/// Norms are over the vertices that can move, but for those that tools hold or touch, that hang on
/// rigid links or belong to other rigid constraints, or whose edges are at the limit of their
/// stretch: what pushes these is no elastic force.
struct Convergence {
  double residual = 0;     ///< N
  double elastic = 0;      ///< N, the norm of f
  Index vertex_count = 0;  ///< how many count

  /// Residual over elastic forces: 0.01 tells of forces that are 1 % off balance. Not of a body in
  /// free flight, where both are rounding. 0 without elastic forces.
  [[nodiscard]] double ratio() const noexcept { return elastic > 0 ? residual / elastic : 0; }
};

}  // namespace pbdsurg
