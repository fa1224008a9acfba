// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold tissue as hard as they press, and no harder.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// A place on tissue: a vertex, or a point of an edge or of a triangle.
struct TissuePoint {
  /// Scene vertices: one, the two of an edge, or the three of a triangle; kInvalidIndex behind them
  std::array<Index, 3> vertices{kInvalidIndex, kInvalidIndex, kInvalidIndex};
  std::array<float, 3> weights{1, 0, 0};  ///< of these, positive; their sum is one, zero behind
};

/// Where jaws press: a rectangle between them, in the tool's frame.
struct JawPad {
  Eigen::Vector3f center{0, 0, 0};  ///< m
  Eigen::Vector3f normal{0, 0, 1};  ///< unit, from one jaw to the other
  Eigen::Vector3f along{1, 0, 0};   ///< unit, at a right angle to the normal: along the jaws
  float half_length = 10e-3F;       ///< m, positive, along the jaws
  float half_width = 2.5e-3F;       ///< m, positive, across them
};

/// N, with which each jaw must press tissue that Solver::close_jaws() grasps: an estimate.
inline constexpr float kLeastPinch = 0.3F;

/// How jaws hold tissue. Along the pad they hold a pull of up to
///
///     2 friction clamp_force    N
///
/// since both jaws rub. Beyond it tissue slides between them, all points alike, and the pull stays
/// there. A point that leaves the pad is let go; when fewer than three are left, so are these.
/// Across the pad, and against being turned, jaws hold without a limit.
struct Grip {
  JawPad pad{};           ///< where jaws press
  float clamp_force = 5;  ///< N, >= 0, with which each jaw presses: Solver::set_clamp_force()
  /// Coefficient of each jaw, >= 0. To bear a pull of 5 N, smooth jaws had to press with 22 N and
  /// profiled ones with 3 N (Heijnsdijk et al., Surg. Endosc. 18 (2004) 974, caecum of pigs): that
  /// is 0.11 and 0.83.
  float friction = 0.8F;
  /// N/m, positive: of the mean pull of a step along the pad, over the width of what is grasped,
  /// across the pull, which is a quarter of the pad's at least. Beyond it the tissue tears. See
  /// pbdsurg/tissue/tear_strength.h.
  float tear_strength = std::numeric_limits<float>::infinity();
  float compliance = 5e-4F;  ///< m/N, positive, of each point
};

/// What became of a grip.
enum class GripState : std::uint8_t {
  open,      ///< holds nothing
  holding,   ///< nothing slid in the last step
  slipping,  ///< something did
  lost,      ///< lets go: fewer than three points were left on the pad
  torn,      ///< lets go: the tissue tore
};

/// A point that jaws hold.
struct GraspedPoint {
  TissuePoint point;       ///< of the tissue
  Eigen::Vector3f anchor;  ///< m, where it is held in the tool's frame
  Eigen::Vector3f force;   ///< N, on the tissue, mean of the last step
};

/// What jaws hold, after the last step.
struct GripReport {
  GripState state = GripState::open;  ///< stays lost or torn until the tool grasps or releases
  std::vector<GraspedPoint> points;   ///< that are held
  float clamp_force = 0;              ///< N, as set
  float slip_limit = 0;               ///< N, the largest pull: 2 friction clamp_force
  float tear_limit = 0;               ///< N, that tears what is held, with a pull as it is
  Eigen::Vector3f pull{0, 0, 0};      ///< N, on the tissue, along the pad, mean of the last step
  float slid = 0;                     ///< m, that tissue slid through the jaws in the last step
  /// Of a torn grip: scene vertices that were held, ascending. What of the mesh tears is for an
  /// edit to say.
  std::vector<Index> torn_vertices;
  /// Of a torn grip: live tetrahedra that join such vertices to others, ascending. An edit that
  /// removes them parts what was grasped from the rest.
  std::vector<Index> torn_tets;
};

}  // namespace pbdsurg
