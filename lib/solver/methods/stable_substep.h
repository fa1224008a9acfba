// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The longest substep in which explicit steps are stable.
///
/// Leapfrog is stable while the substep is shorter than 2 / w, w the highest frequency of
/// the mass matrix M and the stiffness matrix K. By Gershgorin's circle theorem for blocks, w^2 is
/// at most the largest, over vertices i, of
///
///     sum over j of |K_ij| / sqrt(m_i m_j)      |.|: spectral norm of a block of three by three
///
/// with K at rest, which edits change at few vertices. In organs of table 2 it is a fifth to a half
/// more than w^2: that, and kFirstGrowth, are left to what follows.
///
/// Tissue gets stiffer as it is stretched: what a volume adds grows with the square of its faces.
/// So before each step, and every kUnseen substeps within one, the sum of every vertex is taken to
/// grow as the trace of its volumes' part has (VolumeStiffness): one pass over rows, of the same
/// bits for all executors. What is stiffest swings in some substeps, so at an instant it may be
/// where it is soft. Of an undamped swing, displacement and velocity together tell how far it goes:
/// the trace is that where vertices would be some substeps later or earlier, the larger of both.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

class SolverData;
struct CopyState;

class StableSubstep {
 public:
  /// How much a square of frequency may grow before substeps get shorter, and then again and again.
  /// In steps, for substeps whose length changes all the time feed energy into what swings as fast.
  static constexpr double kFirstGrowth = 1.2;
  static constexpr double kNextGrowth = 1.5;
  /// Substeps, between two looks.
  static constexpr int kUnseen = 16;
  /// In longest substeps at rest, how far ahead and back: a swing at the bound takes some three.
  static constexpr double kHeading = 2;
  /// Beyond, no tissue is left to be saved, and nobody is to wait for its substeps.
  static constexpr double kMostGrowth = 16;

  /// Of all vertices. Cost: O(tetrahedra).
  void measure(const SolverData& data);

  /// Makes room where vertices came or went, or have other places. Cost: O(blocks); measure()
  /// those.
  void fit(const SolverData& data);

  /// Of these and their neighbours, whose rows, masses or places have changed.
  void measure(const SolverData& data, std::span<const Index> places);

  /// s, at rest; infinite where nothing swings, zero where no substep is stable.
  [[nodiscard]] double longest() const;

  /// s, with a stiffest_vertex().
  [[nodiscard]] double longest(float stiffest) const;

  /// s, how far ahead and back a look goes.
  [[nodiscard]] PBDSURG_API float heading() const;

  /// [block][lane] 1/(kg) the sum of a vertex over the trace of its volumes, at rest: zero where it
  /// has none. Idle lanes have zero.
  [[nodiscard]] std::span<const float> shares() const noexcept { return shares_; }

  /// Places that were measured last, in an edit.
  [[nodiscard]] std::span<const Index> measured() const noexcept { return changed_; }

  /// Changes with the shares.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Place of the vertex that asks for it.
  [[nodiscard]] Index stiffest() const;

 private:
  void measure_vertex(const SolverData& data, Index place);

  std::vector<Eigen::Vector3d> rest_;  // [place] m
  std::vector<double> squares_;        // [place] 1/s^2, the sum above
  std::vector<float> shares_;
  std::uint64_t revision_ = 0;

  std::vector<Index> changed_;  // of an edit

  // of the vertex at hand
  std::vector<Index> neighbors_;
  std::vector<Eigen::Matrix3d> blocks_;  // N/m, with each
};

/// 1/s^2, the largest share of a vertex times its trace, ahead or back; of vertices that are
/// finite.
[[nodiscard]] float stiffest_vertex(const SolverData& data, const CopyState& copy);

}  // namespace pbdsurg
