// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A move of all vertices at once by the modes of a CoarseSpace, after the first sweep of a
/// substep. With r the forces that sweeps have left out of balance, inertia among them, and
/// P the modes, turned as their piece of tissue is turned now:
///
///     u += t P (1 / h^2 + stiffnesses)^-1 P^T r,
///
/// which for t = 1 is the least energy along these modes, were tissue as stiff as at rest. Forces
/// at t = 1 say whether that went too far; t then is where they balance, by the secant. So a step
/// that a wrong stiffness makes too long is shortened, and shaken tissue comes to rest. t is of a
/// piece.
///
/// Vertices that tools touch or hold, or that custom constraints push, fixed ones, and those at
/// which something is not finite stay where sweeps have left them. What would move those that are
/// held or pushed is opposed by springs, as stiff as tissue around them: one for all holds near a
/// node, at their mean. Constraints of many neighbours, ConstraintSweep::satisfy_together(), let
/// their vertices move, and oppose what would change their value, as far as they are stiff.
///
/// Stages, each over all blocks, nodes or parts of vertices, by any number of workers that meet in
/// between; the numbers are the same for any number, and on a device:
///
///     leave_out_pushed()            one worker
///     find_residuals()              blocks
///     project_residuals()           nodes
///     solve_coarse()                one worker
///     find_moves(), displace()      parts
///     find_residuals()              blocks
///     weigh_moves()                 nodes
///     turn_back_moves(), displace() parts

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/coarse_kernel.h"
#include "lib/solver/methods/vertex_rows.h"

namespace pbdsurg {

class SolverData;
struct StepContext;

/// So many parts of vertices, for any number of workers.
inline constexpr Index kCoarseParts = 16;

/// Constraints of many neighbours, which a correction keeps to: see
/// ConstraintSweep::satisfy_together().
class WideConstraints {
 public:
  struct Corner {
    Index place;
    Vec3<float> gradient;
  };

  void clear() noexcept;
  /// The next one, whose corners then come. Whether there is room for it.
  [[nodiscard]] bool begin(float compliance);
  void add(Index place, const Vec3<float>& gradient) { corners_.push_back({place, gradient}); }

  [[nodiscard]] Index count() const noexcept { return static_cast<Index>(firsts_.size()); }
  [[nodiscard]] float compliance(Index constraint) const { return compliances_[constraint]; }
  [[nodiscard]] std::span<const Corner> corners(Index constraint) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  std::vector<Corner> corners_;
  std::vector<std::size_t> firsts_;
  std::vector<float> compliances_;
};

/// Of one worker.
struct CoarseScratch {
  std::vector<Particle> residuals;       ///< [place] N; w: 1 where the vertex takes part, else 0
  std::vector<Particle> moves;           ///< [place] m, for t = 1; w: 1 where there is one, else 0
  std::vector<NodeSums> sums;            ///< [node] before the move
  std::vector<CoarseGain> gains;         ///< [node]
  std::vector<float> loads, amplitudes;  ///< [number], [mode]
  std::vector<float> sums_of_all;        ///< [kCoarseSums][mode or number]
  std::vector<float> gives;              ///< [mode] s^2, over the inertia and stiffness of a unit
  std::vector<Index> held;               ///< places that stay, ascending
  std::vector<LaneBits> left_out;        ///< [block] theirs, with custom constraints
  std::vector<CoarseShares> hold_sums;   ///< [hold][node] N/m, times 1, X, Y and Z
  std::vector<float> hold_modes;         ///< [mode][row] how modes move them, and change `wide`
  WideConstraints wide;                  ///< of this substep
  std::vector<AffineNumbers> wide_sums;  ///< [node] gradients of one, times shares
  std::vector<float> wide_modes;         ///< [mode] how modes change it
  std::vector<float> numbers;            ///< [number]
  std::vector<AffineNumbers> moves_of_nodes;  ///< [node] m, how each moves what is near
  std::vector<Turn> turns;                    ///< [piece]
  std::uint64_t rows_revision = 0;

  /// Part of StepScratch::fit().
  void fit(const SolverData& data);
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// Whether a substep has it: it takes a sweep before and one after.
[[nodiscard]] bool has_correction(const SolverData& data, int sweeps) noexcept;

/// Places [first, last) of a part.
struct CoarsePart {
  Index first, last;
};
[[nodiscard]] CoarsePart coarse_part(const StepContext& step, Index part) noexcept;

/// With custom constraints: finds out who stays, as VertexState::left_out of the residuals.
void leave_out_pushed(const StepContext& step);

/// Sums up what residuals do to a node, and how what it moves lies.
void project_residuals(const StepContext& step, Index node);

/// From these sums, finds how nodes move.
void solve_coarse(const StepContext& step, float inverse_dt_squared);

/// And so vertices, for t = 1.
void find_moves(const StepContext& step, Index part);

/// Moves them. Kernels on registers stand in for it.
void displace(const StepContext& step, const VertexState& state, Index part);

/// Takes what residuals are now into account.
void weigh_moves(const StepContext& step, Index node);

/// Makes moves the way back to where t wants them. Whether any goes back.
[[nodiscard]] bool turn_back_moves(const StepContext& step, Index part);

}  // namespace pbdsurg
