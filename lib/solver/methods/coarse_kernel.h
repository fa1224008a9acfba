// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a coarse correction (coarse_correction.h) does alike on a host and on a device. Sums here
/// and there go in the same order.

#include <algorithm>
#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/workers.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

inline constexpr int kCoarseNodes = 4;     ///< that move a vertex
inline constexpr int kAffineNumbers = 12;  ///< of a node: for 1, X, Y and Z, a vector each
// From 16 nodes to 48 the error of a motion in 1 ms steps falls by a fifth, from 48 to 96 by a
// tenth; all modes of 48 nodes take off 2 % more than four a node.
inline constexpr Index kVerticesOfNode = 16;  ///< in the mean, at least
inline constexpr Index kMostNodes = 48;       ///< of a scene
inline constexpr Index kModesOfNode = 4;      ///< in the mean, where there are more than
inline constexpr Index kLeastModes = 48;      ///< or as many as there are
inline constexpr Index kMostModes = kModesOfNode * kMostNodes;

/// Nodes of a scene at most.
/// @param free  vertices that move
constexpr Index most_nodes(Index free) {
  return std::clamp<Index>(free / kVerticesOfNode, 1, kMostNodes);
}

/// Member i of a node, or own vertex i, goes to sum i modulo this; then, half by half, sum i takes
/// sum i + half.
inline constexpr Index kNodeSums = 64;
/// So many that follow each other are a part; the sums of parts are added in order.
inline constexpr Index kNodePart = 512;

/// Likewise number i in sums over all numbers, or mode i in sums over all modes.
inline constexpr Index kCoarseSums = 8;

/// So many modes that follow each other are a part of sums over all that are held; the sums of
/// parts are added in order.
inline constexpr Index kModesOfPart = 32;
inline constexpr Index kMostModeParts = kMostModes / kModesOfPart;
static_assert(kMostModes % kModesOfPart == 0);

/// Nodes near which something may be held; near more, corrections know of none.
inline constexpr Index kCoarseHolds = 12;
inline constexpr Index kHoldRows = 3 * kCoarseHolds;  ///< an axis of a hold each

/// Constraints of many neighbours, a row each; corrections know of no more.
inline constexpr Index kMostWides = 12;

/// How nodes move a vertex: by sum_a weights_a (Y_a0 + X Y_a1 + Y Y_a2 + Z Y_a3).
struct alignas(16) CoarseVertex {
  Index nodes[kCoarseNodes]{};
  float weights[kCoarseNodes]{};  ///< sum 1; or all 0: it does not take part
  float place[3]{};               ///< X, Y, Z: where it is at rest in its piece, from -1 to 1
  float stiffness = 0;            ///< N/m, with which its neighbours hold it at rest

  [[nodiscard]] PBDSURG_HOST_DEVICE bool takes_part() const { return weights[0] > 0; }
};

/// How a node moves a vertex: its weight times 1, X, Y and Z.
struct alignas(16) CoarseShares {
  float of[4]{};
};

/// A vector, and one number more, for each of 1, X, Y and Z.
struct alignas(16) AffineNumbers {
  float of[4][4]{};
};

struct NodeSums {
  AffineNumbers load;  ///< N, of residuals of what a node moves, each times its shares
  /// m, of positions of its own vertices from the first one's, each times its place; and how many
  /// count.
  AffineNumbers shape;
};

/// From where positions of a node's own vertices count, of which this is the first: a lost one is
/// nowhere.
PBDSURG_HOST_DEVICE inline Particle shape_origin(const Particle& first) {
  return first.x * first.x + first.y * first.y + first.z * first.z < kInfinity
             ? Particle{first.x, first.y, first.z, 0}
             : Particle{0, 0, 0, 0};
}

/// What moves gain: their power against residuals before and after, J; positive: they go on.
struct CoarseGain {
  double before = 0, after = 0;

  /// t of coarse_correction.h; none of what is not finite.
  [[nodiscard]] PBDSURG_HOST_DEVICE double length() const {
    constexpr double kFurthest = 0.5;  // beyond the balance, as a share of the way there
    const double t = after >= -kFurthest * before ? 1 : before / (before - after);
    return before > 0 && t > 0 && t <= 1 ? t : 0;
  }
};

/// Of a node: the power of how it moves against what residuals do to it.
PBDSURG_HOST_DEVICE inline double power(const AffineNumbers& load, const AffineNumbers& move) {
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      sum += double{load.of[k][axis]} * double{move.of[k][axis]};
    }
  }
  return sum;
}

/// Of a vertex after it has moved; infinitely far back if it has overflown.
PBDSURG_HOST_DEVICE inline double power_after(const Particle& residual, const Particle& move) {
  const double power = double{residual.x} * double{move.x} + double{residual.y} * double{move.y} +
                       double{residual.z} * double{move.z};
  return move.w > 0 && !(residual.w > 0) ? double{-kInfinity} : power;
}

/// From rest to now, of a piece: a rotation, row by row.
struct Turn {
  float of[9]{1, 0, 0, 0, 1, 0, 0, 0, 1};

  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> operator()(const Vec3<float>& v) const {
    return {of[0] * v.x + of[1] * v.y + of[2] * v.z, of[3] * v.x + of[4] * v.y + of[5] * v.z,
            of[6] * v.x + of[7] * v.y + of[8] * v.z};
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> back(const Vec3<float>& v) const {
    return {of[0] * v.x + of[3] * v.y + of[6] * v.z, of[1] * v.x + of[4] * v.y + of[7] * v.z,
            of[2] * v.x + of[5] * v.y + of[8] * v.z};
  }
};

/// Of a matrix: what its entry is multiplied with in its determinant.
PBDSURG_HOST_DEVICE inline double cofactor(const double (&m)[4][4], int row, int column) {
  const int a = (row + 1) % 4, b = (row + 2) % 4, c = (row + 3) % 4;
  const int x = (column + 1) % 4, y = (column + 2) % 4, z = (column + 3) % 4;
  const double minor = m[a][x] * (m[b][y] * m[c][z] - m[b][z] * m[c][y]) -
                       m[a][y] * (m[b][x] * m[c][z] - m[b][z] * m[c][x]) +
                       m[a][z] * (m[b][x] * m[c][y] - m[b][y] * m[c][x]);
  return (row + column) % 2 == 0 ? minor : -minor;
}

/// The rotation that brings places nearest to positions; where they lie on a line, the least turn
/// of those. Horn 1987, "Closed-form solution of absolute orientation using unit quaternions": an
/// eigenvector of a symmetric matrix, here from the largest root of its characteristic polynomial
/// (Theobald 2005, "Rapid calculation of RMSDs using a quaternion-based characteristic
/// polynomial").
/// @param products  [axis][axis] sums of positions times places, both from their means
PBDSURG_HOST_DEVICE inline Turn nearest_turn(const double (&products)[3][3]) {
  constexpr double kBias = 1e-7;  // towards no turn, as a share
  constexpr int kMostSteps = 60;  // of Newton's method; some six where places fill space
  constexpr double kSumOfMost = 1.7320508075688774;  // singular values of a matrix of norm 1
  double square = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      square += products[i][j] * products[i][j];
    }
  }
  if (!(square > 0 && square < 1e300)) {
    return {};
  }
  const double scale = 1 / std::sqrt(square);
  double p[3][3];
  double norm = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      p[i][j] = scale * products[i][j] + (i == j ? kBias : 0);
      norm += p[i][j] * p[i][j];
    }
  }
  double m[4][4] = {
      {p[0][0] + p[1][1] + p[2][2], p[2][1] - p[1][2], p[0][2] - p[2][0], p[1][0] - p[0][1]},
      {p[2][1] - p[1][2], p[0][0] - p[1][1] - p[2][2], p[1][0] + p[0][1], p[0][2] + p[2][0]},
      {p[0][2] - p[2][0], p[1][0] + p[0][1], p[1][1] - p[0][0] - p[2][2], p[2][1] + p[1][2]},
      {p[1][0] - p[0][1], p[0][2] + p[2][0], p[2][1] + p[1][2], p[2][2] - p[0][0] - p[1][1]}};
  // root^4 + c2 root^2 + c1 root + c0
  const double c2 = -2 * norm;
  const double c1 = -8 * (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
                          p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
                          p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]));
  const double c0 = m[0][0] * cofactor(m, 0, 0) + m[0][1] * cofactor(m, 0, 1) +
                    m[0][2] * cofactor(m, 0, 2) + m[0][3] * cofactor(m, 0, 3);
  double root = kSumOfMost * std::sqrt(norm);
  for (int step = 0; step < kMostSteps; ++step) {
    const double squared = root * root;
    const double value = (squared + c2) * squared + c1 * root + c0;
    const double next = root - value / ((4 * squared + 2 * c2) * root + c1);
    if (!(next < root)) {  // it comes from above, up to rounding
      break;
    }
    root = next;
  }
  for (int i = 0; i < 4; ++i) {
    m[i][i] -= root;
  }
  // any row of cofactors is the eigenvector, up to a factor; the longest has lost least
  double w = 0, x = 0, y = 0, z = 0, longest = 0;
  for (int row = 0; row < 4; ++row) {
    const double q[4] = {cofactor(m, row, 0), cofactor(m, row, 1), cofactor(m, row, 2),
                         cofactor(m, row, 3)};
    const double length = std::fabs(q[row]);  // its square, up to a factor
    if (length > longest) {
      longest = length;
      w = q[0];
      x = q[1];
      y = q[2];
      z = q[3];
    }
  }
  const double length = w * w + x * x + y * y + z * z;
  if (!(length > 0)) {
    return {};
  }
  const double twice = 2 / length;
  return {
      {static_cast<float>(1 - twice * (y * y + z * z)), static_cast<float>(twice * (x * y - w * z)),
       static_cast<float>(twice * (x * z + w * y)), static_cast<float>(twice * (x * y + w * z)),
       static_cast<float>(1 - twice * (x * x + z * z)), static_cast<float>(twice * (y * z - w * x)),
       static_cast<float>(twice * (x * z - w * y)), static_cast<float>(twice * (y * z + w * x)),
       static_cast<float>(1 - twice * (x * x + y * y))}};
}

/// Sums over the nodes of a piece, of which nearest_turn() is made.
/// @param sums  [1, X, Y, Z][x, y, z, 1]
PBDSURG_HOST_DEVICE inline Turn turn_of(const double (&sums)[4][4]) {
  const double count = sums[0][3] > 1 ? sums[0][3] : 1;
  double products[3][3];
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) {
      products[axis][k] = sums[k + 1][axis] - sums[0][axis] * sums[k + 1][3] / count;
    }
  }
  return nearest_turn(products);
}

/// What tools hold near some nodes: a spring for each, at the mean of its vertices.
struct CoarseHolds {
  Index count = 0;
  float sums[kCoarseHolds];    ///< N/m, of the stiffnesses of vertices
  Index counts[kCoarseHolds];  ///< of these

  [[nodiscard]] PBDSURG_HOST_DEVICE Index rows() const { return 3 * count; }

  /// m/N, of the tissue around all of them: it goes with their extent, so with a root of their
  /// number.
  [[nodiscard]] PBDSURG_HOST_DEVICE double give(Index hold) const {
    return std::sqrt(double(counts[hold])) / double{sums[hold]};
  }
};

/// What a correction keeps to: springs at holds, and constraints of many neighbours. With more of
/// these, fewer holds.
struct CoarseRows : CoarseHolds {
  Index wides = 0;
  float wide_compliances[kMostWides];  ///< m^3/Pa

  [[nodiscard]] PBDSURG_HOST_DEVICE static constexpr Index most_holds(Index wides) {
    return (kHoldRows - wides) / 3;
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE Index rows() const { return CoarseHolds::rows() + wides; }
  [[nodiscard]] PBDSURG_HOST_DEVICE Index row_of_wide(Index wide) const {
    return CoarseHolds::rows() + wide;
  }

  /// What gives beside the modes.
  /// @param of_modes  what these give
  [[nodiscard]] PBDSURG_HOST_DEVICE double row_give(Index row, double of_modes) const {
    const Index wide = row - CoarseHolds::rows();
    if (wide < 0) {
      return give(row / 3);
    }
    constexpr double kLeast = 1e-4;  // of what modes give: two constraints may say the same
    const double least = kLeast * of_modes;
    const double own{wide_compliances[wide]};
    return !(of_modes > 0) ? 1 : own > least ? own : least;
  }
};

/// Springs at holds, as the modes feel them.
struct HoldSystem {
  double gives[kHoldRows][kHoldRows];  ///< m/N, the lower triangle
  double forces[kHoldRows];            ///< m, how far what is held would move; then N
  double shares[kHoldRows];            ///< of a row, taken off each below

  /// Entries of the system, row after row: its lower triangle, and forces last.
  [[nodiscard]] PBDSURG_HOST_DEVICE static constexpr Index entries(Index rows) {
    return rows * (rows + 1);
  }

  /// Whether it is of the lower triangle, or a force.
  [[nodiscard]] PBDSURG_HOST_DEVICE static constexpr bool has(Index entry, Index rows) {
    const Index row = entry / (rows + 1), other = entry % (rows + 1);
    return other <= row || other == rows;
  }

  /// What modes add to an entry.
  /// @param count  of the modes
  /// @param gives  [mode] see CoarseScratch
  /// @param moves  [mode][rows + 1] how modes move what is held; last, their amplitudes without
  ///               holds
  [[nodiscard]] PBDSURG_HOST_DEVICE static double sum_of_modes(Index entry, Index rows, Index count,
                                                               const double* gives,
                                                               const double* moves) {
    const Index row = entry / (rows + 1), other = entry % (rows + 1);
    double sum = 0;
    for (Index m = 0; m < count; ++m) {
      const double* const of_mode = moves + m * (rows + 1);
      sum += (other == rows ? 1.0 : gives[m]) * of_mode[row] * of_mode[other];
    }
    return sum;
  }

  /// (D + V^T K V)^-1 by Woodbury's identity: D of the modes, V how they move what is held, K
  /// springs.
  /// @param workers  with their share of entries; all meet in here
  /// @param sum_of   (entry) -> what modes add to it
  template <class Workers, class SumOf>
  PBDSURG_HOST_DEVICE void solve(const Workers& workers, const CoarseRows& holds,
                                 const SumOf& sum_of) {
    const Index rows = holds.rows();
    for (Index entry = workers.first; entry < entries(rows); entry += workers.stride) {
      const Index row = entry / (rows + 1), other = entry % (rows + 1);
      if (has(entry, rows)) {
        const double sum = sum_of(entry);
        (other == rows ? forces[row] : gives[row][other]) =
            other == row ? sum + holds.row_give(row, sum) : sum;
      }
    }
    workers.meet();
    // L D L^T; L times D below, D on the diagonal
    for (Index j = 0; j < rows; ++j) {
      for (Index i = j + 1 + workers.first; i < rows; i += workers.stride) {
        shares[i] = gives[i][j] / gives[j][j];
      }
      workers.meet();
      for (Index i = j + 1 + workers.row(); i < rows; i += workers.rows()) {
        if (workers.column() == 0) {
          forces[i] -= shares[i] * forces[j];
        }
        for (Index k = j + 1 + workers.column(); k <= i; k += workers.columns()) {
          gives[i][k] -= shares[i] * gives[k][j];
        }
      }
      workers.meet();
    }
    for (Index i = rows - 1; i > 0; --i) {
      const double force = forces[i] / gives[i][i];
      for (Index j = workers.first; j < i; j += workers.stride) {
        forces[j] -= gives[i][j] * force;
      }
      workers.meet();
    }
    for (Index i = workers.first; i < rows; i += workers.stride) {
      forces[i] /= gives[i][i];
    }
    workers.meet();
  }

  /// What that takes off the amplitude of a mode.
  [[nodiscard]] PBDSURG_HOST_DEVICE float taken(Index rows, float mode_give,
                                                const float* moves) const {
    double load = 0;
    for (Index row = 0; row < rows; ++row) {
      load += double{moves[row]} * forces[row];
    }
    return mode_give * static_cast<float>(load);
  }
};

}  // namespace pbdsurg
