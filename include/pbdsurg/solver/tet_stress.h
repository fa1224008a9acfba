// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How tissue is deformed, and how it resists.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// Of one tetrahedron, which is deformed evenly.
struct TetStress {
  Eigen::Matrix3f deformation;  ///< F: takes sides at rest to those of now
  Eigen::Matrix3f strain;       ///< Green and Lagrange's, (F^T F - 1) / 2
  Eigen::Matrix3f stress;  ///< Pa, Cauchy's: force on an area as it is now; tension is positive
};

/// Elastic stress of tetrahedra of Neo-Hookean bodies, with the rest shapes and stiffnesses that
/// they have now: mu / J (F F^T - (1 + r (1 - J)) J), of the energy in constraints/neo_hookean.h.
/// Fibres along a add k (l - 1) / (l J) (F a) (F a)^T, where they are longer than at rest: l = |F
/// a| > 1, see constraints/fibre.h. Neither friction of the material nor strain limits count. Cost:
/// O(n); positions of a device are read back.
/// @param tets  [n] live
/// @return      [n]
/// @throws InvalidArgument  naming the tetrahedron that is out of range, was removed, or belongs to
/// a
///                          body of springs, and the copy that there is not
[[nodiscard]] PBDSURG_API std::vector<TetStress> tet_stresses(const Solver& solver,
                                                              std::span<const Index> tets,
                                                              Index copy = 0);

}  // namespace pbdsurg
