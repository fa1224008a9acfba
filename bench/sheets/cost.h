// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a sweep over a triangle of a sheet costs, beside one over a tetrahedron.

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg::bench {

/// Medians of rounds, in which all take turns.
struct SheetCost {
  double tetrahedron_ns;          ///< a sweep, with its share of vertices
  double triangle;                ///< tetrahedra: with its share of vertices and hinges
  double bent_triangle;           ///< likewise, of a sheet that is rolled up at rest
  double damped_triangle;         ///< likewise, of a flat one with inner friction
  double triangle_without_hinge;  ///< tetrahedra: where edges have more than two triangles
};

/// @param options  method, executor
[[nodiscard]] SheetCost sheet_cost(const SolverOptions& options);

}  // namespace pbdsurg::bench
