// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Conjugate gradients by one cluster of blocks, which meet twice an iteration. See cuda/README.md.
///
/// All sums run in a fixed order: lanes of a row, rows of a slice, slices of a piece, pieces.

#include <cstdint>

#include <cuda_runtime.h>

#include "cuda/heat/group_inverse.cuh"
#include "cuda/heat/system_kernel.h"
#include "cuda/heat/system_memory.cuh"
#include "lib/heat/system_rows.h"

namespace pbdsurg::cuda {
namespace {

/// One thread's view of the solution.
class SystemSolution {
 public:
  __device__ SystemSolution(const SystemArrays& arrays, const SystemInput& input,
                            unsigned char* shared)
      : a_(arrays),
        in_(input),
        shared_(*reinterpret_cast<SharedSums*>(shared)),
        first_piece_(part(arrays.piece_count, blockIdx.x, gridDim.x)),
        end_piece_(part(arrays.piece_count, blockIdx.x + 1, gridDim.x)),
        first_row_(arrays.pieces[first_piece_]),
        row_count_(arrays.pieces[end_piece_] - first_row_),
        first_entry_(arrays.starts[first_row_]),
        store_(arrays.is_in_shared_memory ? shared + sizeof(SharedSums)
                                          : arrays.store + arrays.block_bytes * blockIdx.x,
               row_count_, arrays.starts[first_row_ + row_count_] - first_entry_),
        warp_(static_cast<int>(threadIdx.x) / kWarp),
        lane_(static_cast<int>(threadIdx.x) % kWarp) {}

  __device__ void run(const SystemOutput& output) {
    take_input();
    meet_all();
    assemble();
    meet_all();
    find_residual();
    if (in_.inverts_groups) {
      __syncthreads();  // other warps have other rows
      sum_groups();
    }
    publish(kSquares, kTotals, kSquaresOfZero);
    prepare_groups();
    const SystemResult result = iterate();
    finish(output);
    if (blockIdx.x == 0 && threadIdx.x == 0) {
      *output.result = result;
    }
  }

 private:
  // Calls begin(), visit(row, piece, lane of the row, whether there is such a row) for rows of each
  // slice, kLanes together, and end(slice): the whole warp each time.
  template <int kLanes, class Begin, class Visit, class End>
  __device__ void for_each_slice(Begin begin, Visit visit, End end) const {
    constexpr int kRows = kWarp / kLanes;
    const Index slices = (end_piece_ - first_piece_) * a_.slices_per_piece;
    for (Index slice = warp_; slice < slices; slice += kWarps) {
      const Index piece = first_piece_ + slice / a_.slices_per_piece;
      const Index end_row = a_.pieces[piece + 1];
      begin();
      for (Index row = a_.pieces[piece] + slice % a_.slices_per_piece * kRows; row < end_row;
           row += a_.slices_per_piece * kRows) {
        const Index own = row + lane_ / kLanes;
        visit(own, piece, lane_ % kLanes, own < end_row);
      }
      end(slice);
    }
  }

  // Adds what lanes have to the sums of a slice.
  __device__ void keep_sum(Sum sum, Index slice, double value) const {
    const double total = sum_lanes(value);
    if (lane_ == 0) {
      shared_.slices[sum][slice] = total;
    }
  }

  // Makes sums of slices to sums of pieces that all blocks see.
  template <class... Sums>
  __device__ void publish(Sums... sums) const {
    __syncthreads();
    const Index piece = first_piece_ + static_cast<Index>(threadIdx.x);
    if (piece < end_piece_) {
      (publish_piece(sums, piece), ...);
    }
    meet_all();
  }

  __device__ void publish_piece(Sum sum, Index piece) const {
    const double* slices = &shared_.slices[sum][(piece - first_piece_) * a_.slices_per_piece];
    double total = 0;
    for (Index i = 0; i < a_.slices_per_piece; ++i) {
      total += slices[i];
    }
    a_.sums[sum * kMostPieces + piece] = total;
  }

  // Of values of pieces; each thread of all blocks has the same bits.
  template <class Value>
  __device__ double sum_pieces(Value value) const {
    double total = 0;
    for (Index piece = lane_; piece < a_.piece_count; piece += kWarp) {
      total += value(piece);
    }
    return sum_lanes(total);
  }

  __device__ double total_of(Sum sum) const {
    return sum_pieces([&](Index piece) { return a_.sums[sum * kMostPieces + piece]; });
  }

  // From the host, once: a read takes about a microsecond, so many are on their way together.
  __device__ void take_input() {
    constexpr int kTogether = 4;
    const Index step = thread_count();
    for (Index t = thread_of_all(); t < a_.tet_count; t += kTogether * step) {
      double scales[kTogether];
#pragma unroll
      for (int k = 0; k < kTogether; ++k) {
        const bool is_there = in_.scales != nullptr && t + k * step < a_.tet_count;
        scales[k] = is_there ? in_.scales[t + k * step] : 1;
      }
#pragma unroll
      for (int k = 0; k < kTogether; ++k) {
        if (t + k * step < a_.tet_count) {
          a_.scales[t + k * step] = scales[k];
        }
      }
    }
    for (Index i = static_cast<Index>(threadIdx.x); i < row_count_; i += kSystemThreads) {
      store_.x[i] = in_.x[first_row_ + i];
      store_.b[i] = in_.b[first_row_ + i];
      store_.diagonal[i] = in_.added[first_row_ + i];
    }
    for (int i = static_cast<int>(threadIdx.x); i <= kMostPieces; i += kSystemThreads) {
      shared_.corrections[i] = 0;
    }
  }

  // Couplings from tetrahedra, in the order of the host; diagonals.
  __device__ void assemble() {
    for_each_slice<1>([] {},
                      [&](Index row, Index piece, int, bool is_there) {
                        if (is_there) {
                          assemble_row(row, piece);
                        }
                      },
                      [](Index) {});
  }

  __device__ void assemble_row(Index row, Index piece) {
    double* const couplings = store_.couplings - first_entry_;
    const Index first = a_.starts[row];
    const Index end = a_.starts[row + 1];
    for (Index e = first; e < end; ++e) {
      couplings[e] = 0;
    }
    constexpr int kTogether = 4;  // tetrahedra whose numbers are on their way at a time
    const Index end_tet = a_.row_tet_starts[row + 1];
    for (Index i = a_.row_tet_starts[row]; i < end_tet; i += kTogether) {
      Index entries[kTogether][3];
      double values[kTogether][3];
#pragma unroll
      for (int j = 0; j < kTogether; ++j) {
        const RowTet* const at = &a_.row_tets[i + j < end_tet ? i + j : i];
        const double scale = i + j < end_tet ? a_.scales[at->tet] : 0;
#pragma unroll
        for (int k = 0; k < 3; ++k) {
          entries[j][k] = at->entries[k];
          values[j][k] =
              scale * a_.conductances[6 * std::size_t(at->tet) + edge_of_corner(at->corner, k)];
        }
      }
#pragma unroll
      for (int j = 0; j < kTogether; ++j) {
#pragma unroll
        for (int k = 0; k < 3; ++k) {
          couplings[entries[j][k]] += values[j][k];
        }
      }
    }
    double sum = 0;
    for (Index e = first; e < end; ++e) {
      sum += couplings[e];
    }
    const Index i = row - first_row_;
    const double factor = in_.is_relative ? sum : 1;
    const double diagonal = store_.diagonal[i] * factor + sum;
    const bool is_free = diagonal > 0 && isfinite(diagonal);
    store_.b[i] = is_free ? store_.b[i] * factor : 0;
    store_.diagonal[i] = is_free ? diagonal : 0;
    store_.inverse[i] = is_free ? 1 / diagonal : 0;
    a_.starting[row] = make_double2(store_.x[i], is_free ? piece : static_cast<int>(kHeldTag));
  }

  // Of x, and of zero; columns get their tags.
  __device__ void find_residual() {
    constexpr int kLanes = 4;
    double squares = 0, squares_of_zero = 0, total = 0;
    for_each_slice<kLanes>(
        [&] { squares = squares_of_zero = total = 0; },
        [&](Index row, Index, int lane, bool is_there) {
          double residual = 0, residual_of_zero = 0;
          const Index end = is_there ? a_.starts[row + 1] : 0;
          for (Index e = is_there ? a_.starts[row] + lane : 0; e < end; e += kLanes) {
            const Index column = a_.columns[e];
            const double2 there = a_.starting[column];
            const auto tag = static_cast<std::uint32_t>(there.y);
            const double flow = store_.couplings[e - first_entry_] * there.x;
            (tag == kHeldTag ? residual_of_zero : residual) += flow;
            store_.columns[e - first_entry_] =
                static_cast<std::uint32_t>(column) | tag << kTagShift;
          }
          residual = sum_lanes<kLanes>(residual);
          residual_of_zero = sum_lanes<kLanes>(residual_of_zero);
          if (is_there && lane == 0) {
            const Index i = row - first_row_;
            const double inverse = store_.inverse[i];
            residual_of_zero += store_.b[i];
            residual += residual_of_zero - store_.diagonal[i] * store_.x[i];
            residual = inverse > 0 ? residual : 0;
            store_.residual[i] = residual;
            a_.pairs[row] = make_double2(inverse * residual, 0);
            squares += residual * residual * inverse;
            squares_of_zero += inverse > 0 ? residual_of_zero * residual_of_zero * inverse : 0;
            total += residual;
          }
        },
        [&](Index slice) {
          keep_sum(kSquares, slice, squares);
          keep_sum(kSquaresOfZero, slice, squares_of_zero);
          keep_sum(kTotals, slice, total);
        });
  }

  // What each slice adds to its row of the system of groups, a warp a row of the system.
  __device__ void sum_groups() {
    double* const sums = shared_.coarse[warp_];
    const auto for_own = [&](auto visit) {
      __syncwarp();
      for (Index piece = lane_; piece < a_.piece_count; piece += kWarp) {
        visit(piece);
      }
      __syncwarp();
    };
    for_each_slice<kWarp>(
        [&] { for_own([&](Index piece) { sums[piece] = 0; }); },
        [&](Index row, Index piece, int lane, bool) {
          const Index i = row - first_row_;
          if (store_.inverse[i] == 0) {
            return;
          }
          for (Index first = a_.starts[row]; first < a_.starts[row + 1]; first += kWarp) {
            const Index e = first + lane;
            const bool is_there = e < a_.starts[row + 1];
            const std::uint32_t tag =
                is_there ? store_.columns[e - first_entry_] >> kTagShift : kHeldTag;
            const double coupling = is_there ? store_.couplings[e - first_entry_] : 0;
            unsigned left = __ballot_sync(kAllLanes, tag != kHeldTag);
            while (left != 0) {
              const std::uint32_t group = __shfl_sync(kAllLanes, tag, __ffs(left) - 1);
              const double sum = sum_lanes(tag == group ? coupling : 0);
              if (lane == 0) {
                sums[group] -= sum;
              }
              left &= ~__ballot_sync(kAllLanes, tag == group);
            }
          }
          if (lane == 0) {
            sums[piece] += store_.diagonal[i];
          }
        },
        [&](Index slice) {
          const Index of_all = first_piece_ * a_.slices_per_piece + slice;
          for_own([&](Index piece) {
            a_.coarse[static_cast<std::size_t>(of_all) * kMostPieces + piece] = sums[piece];
          });
        });
  }

  // The inverse of the system of groups: made, by each block for itself, or taken from before.
  __device__ void prepare_groups() {
    if (!a_.is_grouped) {
      return;
    }
    for (int i = static_cast<int>(threadIdx.x); i < kMostPieces * kMostPieces;
         i += kSystemThreads) {
      const Index row = i / kMostPieces;
      const Index column = i % kMostPieces;
      if (row < a_.piece_count && column < a_.piece_count) {
        double sum = 0;
        if (in_.inverts_groups) {
          for (Index s = row * a_.slices_per_piece; s < (row + 1) * a_.slices_per_piece; ++s) {
            sum += a_.coarse[static_cast<std::size_t>(s) * kMostPieces + column];
          }
        } else {
          sum = a_.group_inverse[i];
        }
        shared_.inverse[row][column] = sum;
      }
    }
    __syncthreads();
    if (in_.inverts_groups) {
      invert_groups(a_, shared_);
    }
  }

  // Finds what each group is moved by; returns the product of that and the residual.
  __device__ double correct_groups() {
    const auto totals = [&](Index piece) { return a_.sums[kTotals * kMostPieces + piece]; };
    const auto group = static_cast<Index>(threadIdx.x) / kThreadsPerPiece;
    double sum = 0;
    if (group < a_.piece_count) {
      for (Index other = static_cast<Index>(threadIdx.x) % kThreadsPerPiece; other < a_.piece_count;
           other += kThreadsPerPiece) {
        sum += shared_.inverse[group][other] * totals(other);
      }
    }
    sum = sum_lanes<kThreadsPerPiece>(sum);
    if (group < a_.piece_count && threadIdx.x % kThreadsPerPiece == 0) {
      shared_.corrections[group] = sum;
    }
    __syncthreads();
    return sum_pieces([&](Index piece) { return shared_.corrections[piece] * totals(piece); });
  }

  // The new direction, of others as they will have it, too; its product with the matrix.
  __device__ void multiply(double share_of_last) {
    constexpr int kLanes = 4;
    constexpr int kTogether = 4;  // neighbours on their way at a time
    const auto direction = [&](double2 pair, std::uint32_t tag) {
      return pair.x + shared_.corrections[tag] + share_of_last * pair.y;
    };
    double curvature = 0;
    for_each_slice<kLanes>(
        [&] { curvature = 0; },
        [&](Index row, Index piece, int lane, bool is_there) {
          double sum = 0;
          const Index end = is_there ? a_.starts[row + 1] - first_entry_ : 0;
          for (Index first = is_there ? a_.starts[row] - first_entry_ + lane : 0; first < end;
               first += kTogether * kLanes) {
            double couplings[kTogether];
            std::uint32_t columns[kTogether];
            double2 pairs[kTogether];
#pragma unroll
            for (int k = 0; k < kTogether; ++k) {
              const Index e = first + k * kLanes;
              couplings[k] = e < end ? store_.couplings[e] : 0;
              columns[k] = store_.columns[e < end ? e : first];
            }
#pragma unroll
            for (int k = 0; k < kTogether; ++k) {
              pairs[k] = a_.pairs[columns[k] & kColumnBits];
            }
#pragma unroll
            for (int k = 0; k < kTogether; ++k) {
              sum += couplings[k] * direction(pairs[k], columns[k] >> kTagShift);
            }
          }
          sum = sum_lanes<kLanes>(sum);
          if (is_there && lane == 0) {
            const Index i = row - first_row_;
            const bool is_free = store_.inverse[i] > 0;
            const double own =
                direction(a_.pairs[row], is_free ? static_cast<std::uint32_t>(piece) : kHeldTag);
            const double product = is_free ? store_.diagonal[i] * own - sum : 0;
            store_.direction[i] = own;
            store_.product[i] = product;
            curvature += own * product;
          }
        },
        [&](Index slice) { keep_sum(kCurvatures, slice, curvature); });
  }

  __device__ void advance(double length) {
    double squares = 0, total = 0;
    for_each_slice<1>([&] { squares = total = 0; },
                      [&](Index row, Index, int, bool is_there) {
                        if (is_there) {
                          const Index i = row - first_row_;
                          const double direction = store_.direction[i];
                          const double residual = store_.residual[i] - length * store_.product[i];
                          const double scaled = residual * store_.inverse[i];
                          store_.x[i] += length * direction;
                          store_.residual[i] = residual;
                          a_.pairs[row] = make_double2(scaled, direction);
                          squares += residual * scaled;
                          total += residual;
                        }
                      },
                      [&](Index slice) {
                        keep_sum(kSquares, slice, squares);
                        keep_sum(kTotals, slice, total);
                      });
  }

  __device__ SystemResult iterate() {
    SystemResult result{total_of(kSquares), total_of(kSquaresOfZero), 0};
    if (result.scale == 0 && result.squares > 0) {
      for (Index i = static_cast<Index>(threadIdx.x); i < row_count_; i += kSystemThreads) {
        store_.x[i] = store_.inverse[i] > 0 ? 0 : store_.x[i];
      }
      __syncthreads();
      result.squares = 0;
    }
    const double enough = in_.tolerance * in_.tolerance * result.scale;
    double last_product = 1;
    while (result.squares > enough && result.iterations < in_.most_iterations) {
      const double product = result.squares + (a_.is_grouped ? correct_groups() : 0);
      multiply(result.iterations == 0 ? 0 : product / last_product);
      last_product = product;
      publish(kCurvatures);
      const double curvature = total_of(kCurvatures);
      const double length = product / curvature;
      if (!(curvature > 0) || !isfinite(length)) {
        break;
      }
      ++result.iterations;
      advance(length);
      publish(kSquares, kTotals);
      result.squares = total_of(kSquares);
    }
    return result;
  }

  // To the host, each as soon as it is known.
  __device__ void finish(const SystemOutput& output) {
    for (Index i = static_cast<Index>(threadIdx.x); i < row_count_; i += kSystemThreads) {
      output.x[first_row_ + i] = store_.x[i];
      a_.starting[first_row_ + i].x = store_.x[i];
    }
    if (output.tet_heat == nullptr) {
      return;
    }
    meet_all();
    for (Index t = thread_of_all(); t < a_.tet_count; t += thread_count()) {
      const int4 corners = a_.corners[t];
      const double x[4] = {a_.starting[corners.x].x, a_.starting[corners.y].x,
                           a_.starting[corners.z].x, a_.starting[corners.w].x};
      const double* const conductances = &a_.conductances[6 * std::size_t(t)];
      double heat = 0;
      int k = 0;
#pragma unroll
      for (int a = 0; a < 4; ++a) {
#pragma unroll
        for (int b = a + 1; b < 4; ++b, ++k) {
          heat += conductances[k] * (x[a] - x[b]) * (x[a] - x[b]);
        }
      }
      heat *= a_.scales[t];
      a_.tet_heat[t] = heat;
      output.tet_heat[t] = heat;
    }
    meet_all();
    constexpr int kLanes = 4;
    for_each_slice<kLanes>([] {},
                           [&](Index row, Index, int lane, bool is_there) {
                             double heat = 0;
                             const Index end = is_there ? a_.row_tet_starts[row + 1] : 0;
                             for (Index i = is_there ? a_.row_tet_starts[row] + lane : 0; i < end;
                                  i += kLanes) {
                               heat += a_.tet_heat[a_.row_tets[i].tet];
                             }
                             heat = sum_lanes<kLanes>(heat);
                             if (is_there && lane == 0) {
                               const Index i = row - first_row_;
                               const double drop = 1 - store_.x[i];
                               output.row_heat[row] = heat / 4 + store_.b[i] * drop * drop;
                             }
                           },
                           [](Index) {});
  }

  const SystemArrays& a_;
  const SystemInput& in_;
  SharedSums& shared_;
  Index first_piece_, end_piece_, first_row_, row_count_, first_entry_;
  BlockStore store_;
  int warp_, lane_;
};

}  // namespace
}  // namespace pbdsurg::cuda
