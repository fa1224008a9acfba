// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a bar comes to rest, in double precision and without a solver of the library.

#include <Eigen/SparseCore>
#include <vector>

#include "bench/convergence/cantilever.h"
#include "bench/convergence/neo_hookean.h"

namespace pbdsurg::bench {

/// Elastic energy and weight of a bar.
class BarEnergy {
 public:
  explicit BarEnergy(const Cantilever& bar);

  /// J, without the constant of the rest state.
  [[nodiscard]] double value(const std::vector<Eigen::Vector3d>& positions) const;

  /// Out-of-balance force on each vertex, N; zero on fixed ones.
  [[nodiscard]] std::vector<Eigen::Vector3d> forces(
      const std::vector<Eigen::Vector3d>& positions) const;

  /// Second derivative, N/m; of fixed vertices a diagonal of one.
  [[nodiscard]] Eigen::SparseMatrix<double> hessian(
      const std::vector<Eigen::Vector3d>& positions) const;

  /// Sum of the magnitudes of the forces over the weight of all that is free: one at rest shape.
  [[nodiscard]] double residual(const std::vector<Eigen::Vector3d>& positions) const;

  /// The same with the forces of inertia: what a substep leaves of implicit Euler's equation.
  /// @param inertial   [vertex_count] m, where vertices would be without elasticity
  /// @param dt         s, of the substep
  [[nodiscard]] double step_residual(const std::vector<Eigen::Vector3d>& positions,
                                     const std::vector<Eigen::Vector3d>& inertial, double dt) const;

 private:
  const Cantilever& bar_;
  NeoHookeanModuli moduli_;
  std::vector<Element> elements_;
};

/// Newton's method with a sparse Cholesky factorisation.
/// @return  [vertex_count] m
/// @throws Error  unless the residual falls below 1e-9
[[nodiscard]] std::vector<Eigen::Vector3d> find_equilibrium(const Cantilever& bar);

/// Of the lowest mode, 1/s: Rayleigh's quotient of the shape in which the bar sags.
[[nodiscard]] double lowest_frequency(const Cantilever& bar,
                                      const std::vector<Eigen::Vector3d>& equilibrium);

}  // namespace pbdsurg::bench
