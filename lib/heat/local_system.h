// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Symmetric sparse systems over some vertices of a mesh, solved by conjugate gradients.

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/types.h"

#include "lib/heat/system_rows.h"

namespace pbdsurg {

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
/// by a correction that is constant in each group, which halves the iterations of a potential
/// (bench/potential_bench.cpp) and would not help where the added part prevails. Sums run over
/// fixed pieces of the rows, so the bits are the same for any number of threads; and over columns
/// as they ascend, so tetrahedra without conductance change none. Allocates nothing while sizes are
/// not larger than before.
class LocalSystem {
 public:
  static constexpr Index kMostGroups = 64;

  /// Solutions that take the same correction. Changed rows make it less apt, not wrong: to follow
  /// them each time would cost as much as several iterations.
  static constexpr int kMostUsesOfInverse = 10;

  /// @param executor  shares the work on systems that are large enough
  explicit LocalSystem(Executor executor = {}) : executor_(std::move(executor)) {}

  /// Takes new rows, coupled where they share a tetrahedron; all couplings are then zero, nothing
  /// is added and nothing grouped. Cost: O(rows + tets).
  /// @param tets  [tet_count] rows at the corners, each in [0, row_count); ordered, since sums run
  ///              in this order. A triangle repeats its last corner, and no edge there conducts.
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

  /// Adds a correction that is constant in each group of consecutive rows to the preconditioner.
  /// It is made for what the system is at the first solution after this or set_couplings(), and
  /// again after every ten that follow changes, at a cost of O(entries + groups^3).
  /// @param starts  [group_count + 1] first row of each group, ascending, from 0 to row_count();
  ///                at most kMostGroups groups
  void set_groups(std::span<const Index> starts);

  [[nodiscard]] Index row_count() const noexcept { return static_cast<Index>(diagonal_.size()); }

  /// Valid until the next set_rows() or set_groups().
  [[nodiscard]] SystemRows rows() const noexcept;

  /// out_i = sum_j c_ij (x_j - x_i): exactly zero for a uniform x.
  /// @param x    [row_count]
  /// @param out  [row_count]
  void flows(std::span<const double> x, std::span<double> out) const;

  /// sum_j c_ij of a row, which is what couplings have on the diagonal
  [[nodiscard]] double coupling_sum(Index row) const { return coupling_sums_[row]; }

  /// out_i = the sum of values over the elements that have row i as a corner, each once.
  /// @param values  [tet_count]
  /// @param out     [row_count]
  void sum_at_corners(std::span<const double> values, std::span<double> out) const;

  /// Solves A x = b on the free rows. Without an answer in the iterations allowed, x is the best
  /// so far, in energy.
  /// @param b  [row_count] those of held rows count nothing
  /// @param x  [row_count] where to start; the solution
  LinearSolveReport solve(std::span<const double> b, std::span<double> x,
                          const LinearSolveOptions& options);

 private:
  template <class Job>
  void share(int passes, const Job& job) const;  // over all rows; calls job(worker) on each thread
  [[nodiscard]] Index piece_count() const { return static_cast<Index>(pieces_.size()) - 1; }
  void sum_row(Index row, std::span<const std::array<double, 6>> conductances);
  template <class Worker>
  void iterate(const Worker& worker, std::span<const double> b, std::span<double> x,
               bool starts_at_zero, const LinearSolveOptions& options, LinearSolveReport& report);
  void prepare();
  void invert_groups();

  Executor executor_;
  std::vector<Index> row_tet_starts_;  // [row_count + 1]
  std::vector<RowTet> row_tets_;       // [4 tet_count] those of a row in the order of tets
  std::vector<Index> starts_;          // [row_count + 1]
  std::vector<Index> columns_;         // [entry_count] ascending in each row
  std::vector<double> couplings_;      // [entry_count] c_ij
  std::vector<double> coupling_sums_;  // [row_count]
  std::vector<double> added_;          // [row_count]
  std::vector<double> diagonal_;       // [row_count]
  std::vector<double> inverses_;       // [row_count] of the diagonal; 0: held
  std::vector<Index> pieces_;          // [piece_count + 1] first rows
  bool is_grouped_ = false;            // then the pieces are the groups
  bool is_prepared_ = false;
  int uses_of_inverse_ = 0;
  int last_iterations_ = 0;
  std::vector<double> group_inverse_;                   // [group_count, group_count]
  std::vector<Index> marks_;                            // [row_count] scratch of set_rows()
  std::vector<Index> group_of_;                         // [row_count] scratch of invert_groups()
  std::vector<double> residual_, direction_, product_;  // [row_count]
  std::vector<double> sums_, other_sums_, group_residuals_;  // [piece_count]
};

}  // namespace pbdsurg
