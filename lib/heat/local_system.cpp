// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/local_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lib/base/shared_work.h"

namespace pbdsurg {
namespace {

// Below this, threads that share an iteration wait for each other longer than they work.
constexpr Index kRowsWorthThreads = 2000;
constexpr Index kRowsPerPiece = 128;

// Of its own diagonal: a smaller pivot is what rounding leaves of a group that nothing holds.
constexpr double kLeastPivot = 1e-12;

// Calls visit(piece) for a worker's share of the pieces.
template <class Visit>
void for_each_piece(const Worker& worker, Index pieces, Visit visit) {
  const auto first = static_cast<Index>(std::int64_t{pieces} * worker.thread / worker.count);
  const auto last = static_cast<Index>(std::int64_t{pieces} * (worker.thread + 1) / worker.count);
  for (Index piece = first; piece < last; ++piece) {
    visit(piece);
  }
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

template <class Job>
void LocalSystem::share(int passes, const Job& job) const {
  const std::int64_t visits =
      row_count() < kRowsWorthThreads ? 0 : std::int64_t{row_count()} * passes;
  share_work(executor_, visits, job);
}

void LocalSystem::set_rows(Index row_count, std::span<const Tet> tets) {
  const auto rows = static_cast<std::size_t>(row_count);
  row_tet_starts_.assign(rows + 1, 0);
  for (const Tet& tet : tets) {
    for (const Index row : tet) {
      ++row_tet_starts_[row + 1];
    }
  }
  std::partial_sum(row_tet_starts_.begin(), row_tet_starts_.end(), row_tet_starts_.begin());
  row_tets_.resize(4 * tets.size());
  marks_.assign(row_tet_starts_.begin(), row_tet_starts_.end() - 1);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int corner = 0; corner < 4; ++corner) {
      row_tets_[marks_[tets[t][corner]]++] = {static_cast<Index>(t), corner, {}};
    }
  }

  starts_.assign(rows + 1, 0);
  columns_.clear();
  marks_.assign(rows, kInvalidIndex);  // entry of each column in this row
  for (Index row = 0; row < row_count; ++row) {
    for (Index i = row_tet_starts_[row]; i < row_tet_starts_[row + 1]; ++i) {
      for (const Index column : tets[row_tets_[i].tet]) {
        if (column != row && marks_[column] < starts_[row]) {
          marks_[column] = starts_[row];
          columns_.push_back(column);
        }
      }
    }
    starts_[row + 1] = static_cast<Index>(columns_.size());
    std::sort(columns_.begin() + starts_[row], columns_.end());
    for (Index e = starts_[row]; e < starts_[row + 1]; ++e) {
      marks_[columns_[e]] = e;
    }
    for (Index i = row_tet_starts_[row]; i < row_tet_starts_[row + 1]; ++i) {
      RowTet& at = row_tets_[i];
      for (int k = 0; k < 3; ++k) {
        const Index column = tets[at.tet][k < at.corner ? k : k + 1];
        at.entries[k] = column == row ? starts_[row] : marks_[column];  // takes nothing
      }
    }
  }

  couplings_.assign(columns_.size(), 0.0);
  for (auto* values :
       {&coupling_sums_, &added_, &diagonal_, &inverses_, &residual_, &direction_, &product_}) {
    values->assign(rows, 0.0);
  }
  is_grouped_ = false;
  is_prepared_ = false;
  pieces_.clear();
  for (Index row = 0; row < row_count; row += kRowsPerPiece) {
    pieces_.push_back(row);
  }
  pieces_.push_back(row_count);
}

void LocalSystem::set_groups(std::span<const Index> starts) {
  pieces_.assign(starts.begin(), starts.end());
  is_grouped_ = true;
  is_prepared_ = false;
  uses_of_inverse_ = kMostUsesOfInverse;
}

void LocalSystem::sum_row(Index row, std::span<const std::array<double, 6>> conductances) {
  std::fill(couplings_.begin() + starts_[row], couplings_.begin() + starts_[row + 1], 0.0);
  for (Index i = row_tet_starts_[row]; i < row_tet_starts_[row + 1]; ++i) {
    const RowTet& at = row_tets_[i];
    for (int k = 0; k < 3; ++k) {
      couplings_[at.entries[k]] += conductances[at.tet][edge_of_corner(at.corner, k)];
    }
  }
  coupling_sums_[row] = std::accumulate(couplings_.begin() + starts_[row],
                                        couplings_.begin() + starts_[row + 1], 0.0);
}

void LocalSystem::set_couplings(std::span<const std::array<double, 6>> conductances) {
  share(1, [&](const Worker& worker) {
    for_each_piece(worker, piece_count(), [&](Index piece) {
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        sum_row(row, conductances);
      }
    });
  });
  is_prepared_ = false;
  uses_of_inverse_ = kMostUsesOfInverse;
}

void LocalSystem::update_couplings(std::span<const std::array<double, 6>> conductances,
                                   std::span<const Index> rows) {
  for (const Index row : rows) {
    sum_row(row, conductances);
  }
  is_prepared_ = false;
}

void LocalSystem::set_added(std::span<const double> added) {
  added_.assign(added.begin(), added.end());
  is_prepared_ = false;
}

SystemRows LocalSystem::rows() const noexcept {
  return {starts_, columns_, row_tet_starts_, row_tets_,
          is_grouped_ ? std::span<const Index>(pieces_) : std::span<const Index>{}};
}

void LocalSystem::flows(std::span<const double> x, std::span<double> out) const {
  share(1, [&](const Worker& worker) {
    for_each_piece(worker, piece_count(), [&](Index piece) {
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        double flow = 0;
        for (Index e = starts_[row]; e < starts_[row + 1]; ++e) {
          flow += couplings_[e] * (x[columns_[e]] - x[row]);
        }
        out[row] = flow;
      }
    });
  });
}

void LocalSystem::sum_at_corners(std::span<const double> values, std::span<double> out) const {
  share(1, [&](const Worker& worker) {
    for_each_piece(worker, piece_count(), [&](Index piece) {
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        out[row] = 0;
        Index last = kInvalidIndex;
        for (Index i = row_tet_starts_[row]; i < row_tet_starts_[row + 1]; ++i) {
          const Index tet = row_tets_[i].tet;
          out[row] += tet == last ? 0 : values[tet];
          last = tet;
        }
      }
    });
  });
}

void LocalSystem::prepare() {
  for (std::size_t row = 0; row < diagonal_.size(); ++row) {
    const double sum = added_[row] + coupling_sums_[row];
    const bool is_free = sum > 0 && std::isfinite(sum);
    diagonal_[row] = is_free ? sum : 0;
    inverses_[row] = is_free ? 1 / sum : 0;
  }
  const auto pieces = static_cast<std::size_t>(piece_count());
  sums_.assign(pieces, 0.0);
  other_sums_.assign(pieces, 0.0);
  group_residuals_.assign(pieces, 0.0);
  if (is_grouped_ && ++uses_of_inverse_ > kMostUsesOfInverse) {
    invert_groups();
    uses_of_inverse_ = 1;
  }
  is_prepared_ = true;
}

// Gauss-Jordan, which needs no pivoting for a positive definite matrix.
void LocalSystem::invert_groups() {
  const auto groups = static_cast<std::size_t>(piece_count());
  group_of_.resize(diagonal_.size());
  for (std::size_t group = 0; group < groups; ++group) {
    std::fill(group_of_.begin() + pieces_[group], group_of_.begin() + pieces_[group + 1],
              static_cast<Index>(group));
  }
  group_inverse_.assign(groups * groups, 0.0);
  for (std::size_t row = 0; row < diagonal_.size(); ++row) {
    if (inverses_[row] > 0) {
      double* sums = &group_inverse_[group_of_[row] * groups];
      sums[group_of_[row]] += diagonal_[row];
      for (Index e = starts_[row]; e < starts_[row + 1]; ++e) {
        if (inverses_[columns_[e]] > 0) {
          sums[group_of_[columns_[e]]] -= couplings_[e];
        }
      }
    }
  }
  std::array<double, kMostGroups> least;
  for (std::size_t k = 0; k < groups; ++k) {
    least[k] = kLeastPivot * group_inverse_[k * groups + k];
  }
  for (std::size_t k = 0; k < groups; ++k) {
    double* pivots = &group_inverse_[k * groups];
    const bool is_regular = pivots[k] > least[k];
    const double inverse = is_regular ? 1 / pivots[k] : 0;  // else the group is left alone
    pivots[k] = 1;
    for (std::size_t j = 0; j < groups; ++j) {
      pivots[j] *= inverse;
    }
    for (std::size_t i = 0; i < groups; ++i) {
      double* row = &group_inverse_[i * groups];
      const double factor = row[k];
      if (i != k) {
        row[k] = 0;
        for (std::size_t j = 0; j < groups; ++j) {
          row[j] -= factor * pivots[j];
        }
      }
    }
  }
}

LinearSolveReport LocalSystem::solve(std::span<const double> b, std::span<double> x,
                                     const LinearSolveOptions& options) {
  if (!is_prepared_) {
    prepare();
  }
  LinearSolveReport report;
  const bool starts_at_zero = std::ranges::all_of(x, [](double value) { return value == 0; });
  share(last_iterations_ + 1,  // as many as last, by guess
        [&](const Worker& worker) { iterate(worker, b, x, starts_at_zero, options, report); });
  last_iterations_ = report.iterations;
  return report;
}

template <class Worker>
void LocalSystem::iterate(const Worker& worker, std::span<const double> b, std::span<double> x,
                          bool starts_at_zero, const LinearSolveOptions& options,
                          LinearSolveReport& report) {
  const Index pieces = piece_count();
  for_each_piece(worker, pieces, [&](Index piece) {
    double squares = 0, squares_of_zero = 0, total = 0;
    for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
      residual_[row] = direction_[row] = product_[row] = 0;
      if (inverses_[row] == 0) {
        continue;
      }
      double residual_of_zero = b[row];
      double residual = -diagonal_[row] * x[row];
      const Index end = starts_at_zero ? starts_[row] : starts_[row + 1];  // nothing flows at zero
      for (Index e = starts_[row]; e < end; ++e) {
        const double flow = couplings_[e] * x[columns_[e]];
        (inverses_[columns_[e]] > 0 ? residual : residual_of_zero) += flow;
      }
      residual += residual_of_zero;
      squares_of_zero += residual_of_zero * residual_of_zero * inverses_[row];
      squares += residual * residual * inverses_[row];
      residual_[row] = residual;
      total += residual;
    }
    sums_[piece] = squares;
    other_sums_[piece] = squares_of_zero;
    group_residuals_[piece] = total;
  });
  worker.barrier();
  const double scale = sum_of(other_sums_);
  double squares = sum_of(sums_);
  if (scale == 0 && squares > 0) {
    worker.barrier();  // all have read the sums
    for_each_piece(worker, pieces, [&](Index piece) {
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        x[row] = inverses_[row] > 0 ? 0 : x[row];
      }
    });
    squares = 0;
  }
  double last_product = 0;
  int iterations = 0;
  std::array<double, kMostGroups> correction{};
  const double enough = options.tolerance * options.tolerance * scale;
  while (squares > enough && iterations < options.most_iterations) {
    double product = squares;  // of the residual and what the preconditioner makes of it
    if (is_grouped_) {
      for (Index g = 0; g < pieces; ++g) {
        const double* inverse = &group_inverse_[static_cast<std::size_t>(g) * pieces];
        correction[g] =
            std::inner_product(group_residuals_.begin(), group_residuals_.end(), inverse, 0.0);
        product += correction[g] * group_residuals_[g];
      }
    }
    const double share_of_last = iterations == 0 ? 0 : product / last_product;
    last_product = product;
    for_each_piece(worker, pieces, [&](Index piece) {
      const double constant = is_grouped_ ? correction[piece] : 0;
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        const double start = inverses_[row] > 0 ? constant : 0;
        direction_[row] = start + inverses_[row] * residual_[row] + share_of_last * direction_[row];
      }
    });
    worker.barrier();
    for_each_piece(worker, pieces, [&](Index piece) {
      double curvature = 0;
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        if (inverses_[row] == 0) {
          continue;
        }
        double value = diagonal_[row] * direction_[row];
        for (Index e = starts_[row]; e < starts_[row + 1]; ++e) {
          value -= couplings_[e] * direction_[columns_[e]];
        }
        product_[row] = value;
        curvature += direction_[row] * value;
      }
      other_sums_[piece] = curvature;
    });
    worker.barrier();
    const double curvature = sum_of(other_sums_);
    const double length = product / curvature;
    if (!(curvature > 0) || !std::isfinite(length)) {
      break;  // all that rounding leaves, or not a number from the caller
    }
    ++iterations;
    for_each_piece(worker, pieces, [&](Index piece) {
      double squares_here = 0, total = 0;
      for (Index row = pieces_[piece]; row < pieces_[piece + 1]; ++row) {
        x[row] += length * direction_[row];
        residual_[row] -= length * product_[row];
        squares_here += residual_[row] * residual_[row] * inverses_[row];
        total += residual_[row];
      }
      sums_[piece] = squares_here;
      group_residuals_[piece] = total;
    });
    worker.barrier();
    squares = sum_of(sums_);
  }
  if (worker.thread == 0) {
    report = {iterations, scale > 0 ? std::sqrt(squares / scale) : 0, squares <= enough};
  }
}

}  // namespace pbdsurg
