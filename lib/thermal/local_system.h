// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Symmetric sparse systems over some vertices of a mesh, solved by conjugate gradients.

#include <array>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg {

class StepTeam;

struct LinearSolveOptions {
  double tolerance = 1e-6;    ///< of the residual, relative to that of x = 0 on the free rows
  int most_iterations = 500;  ///< >= 0
};

struct LinearSolveReport {
  int iterations = 0;
  double residual = 0;  ///< relative, as LinearSolveOptions::tolerance
  bool converged = true;
};

/// A x = (added_i + sum_j c_ij) x_i - sum_j c_ij x_j, where c_ij sums the conductances of the edge
/// i-j over the tetrahedra that have it: linear finite elements for diffusion, (M/(theta dt) + K)
/// for heat, K and contact conductances for potential. A negative c_ij, which obtuse tetrahedra
/// cause, is as good as any.
///
/// Rows are local ids, which the caller gives to vertices. A row whose added part is infinite is
/// held: it keeps its x; so does one with nothing on its diagonal, which nothing couples. Solved
/// by conjugate gradients, preconditioned by the diagonal and, where the caller groups the rows,
/// by a correction that is constant in each group. Sums run over fixed pieces, so the bits are the
/// same for any number of threads. Allocates nothing while sizes are not larger than before.
class LocalSystem {
 public:
  /// @param team  shares the work on systems that are large enough; may be null; outlives this
  explicit LocalSystem(StepTeam* team = nullptr) : team_(team) {}

  /// Takes new rows, coupled where they share a tetrahedron; all couplings are then zero, nothing
  /// is added and nothing grouped. Cost: O(rows + tets).
  /// @param tets  [tet_count] rows at the corners, each in [0, row_count); ordered, since sums run
  ///              in this order
  void set_rows(Index row_count, std::span<const Tet> tets);

  /// Sums all couplings afresh. Cost: O(tets).
  /// @param conductances  [tet_count] of the edges in the order of kTetEdges, W/K or S; finite
  void set_couplings(std::span<const std::array<double, 6>> conductances);

  /// Sums those of some rows afresh, to the same bits. Cost: O(tets at these rows).
  /// @param rows  all corners of tetrahedra whose conductances have changed
  void update_couplings(std::span<const std::array<double, 6>> conductances,
                        std::span<const Index> rows);

  /// @param added  [row_count] what the diagonal has beyond couplings, >= 0; infinite: held
  void set_added(std::span<const double> added);

  [[nodiscard]] Index row_count() const noexcept { return static_cast<Index>(diagonal_.size()); }

  /// out_i = sum_j c_ij (x_j - x_i): exactly zero for a uniform x.
  /// @param x    [row_count]
  /// @param out  [row_count]
  void flows(std::span<const double> x, std::span<double> out) const;

  /// Solves A x = b on the free rows. Without an answer in the iterations allowed, x is the best
  /// so far, in energy.
  /// @param b  [row_count] those of held rows count nothing
  /// @param x  [row_count] where to start; the solution
  LinearSolveReport solve(std::span<const double> b, std::span<double> x,
                          const LinearSolveOptions& options);
};

}  // namespace pbdsurg
