// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the solver knows of jaws that hold with a limit.

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstddef>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/grip.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// Points that jaws hold at least.
inline constexpr std::size_t kLeastGripPoints = 3;

/// A point that jaws hold.
struct GripPoint {
  TissuePoint at;
  Eigen::Vector3f anchor;               ///< m, in the tool's frame
  Eigen::Vector3f target{0, 0, 0};      ///< m, of the current substep, while nothing slides
  Eigen::Vector3f multiplier{0, 0, 0};  ///< kg m
  Eigen::Vector3f force{0, 0, 0};       ///< N, on the tissue, mean of the last step
};

/// A vertex of such points.
struct GripCorner {
  Index vertex;
  float share;  ///< mean of its weights over all points
  auto operator<=>(const GripCorner& other) const noexcept = default;
};

/// Of one tool.
struct ToolGrip {
  Grip limits;
  GripState state = GripState::open;
  std::array<Index, 2> jaws{kInvalidIndex, kInvalidIndex};  ///< tools that push nothing meanwhile
  std::vector<GripPoint> points;
  std::vector<GripCorner> corners;  ///< each vertex once, ascending
  Eigen::Vector3f normal{0, 0, 1};  ///< of the pad in the scene, in the current substep
  Eigen::Vector3f slide{0, 0, 0};   ///< m, of all targets in the current substep
  bool slid_before = false;         ///< whether they did in the one before
  Eigen::Vector3f pull{0, 0, 0};    ///< N, on the tissue, along the pad, mean of the last step
  float slid = 0;                   ///< m, in the last step
  std::vector<Index> torn;          ///< vertices, ascending
  bool let_go_now = false;          ///< whether it was lost or torn in the last step

  /// Whether jaws are shut around something.
  [[nodiscard]] bool is_shut() const noexcept {
    return state == GripState::holding || state == GripState::slipping;
  }

  /// Finds the corners of the points.
  void find_corners();

  /// Holds nothing from here on.
  void let_go(GripState why);

  /// m, how wide the points lie on the pad across a direction.
  /// @param direction  in the tool's frame
  [[nodiscard]] float width_across(const Eigen::Vector3f& direction) const;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// How many vertices a point has.
[[nodiscard]] PBDSURG_API int corner_count(const TissuePoint& point) noexcept;

/// Whether the vertices of a point are those of living tissue: a vertex, an edge or a face of a
/// tetrahedron, or an edge or all of a triangle of a sheet.
[[nodiscard]] bool is_on_tissue(const Tissue& tissue, const TissuePoint& point);

/// Whether a place of the tool's frame is on the pad or above it.
[[nodiscard]] bool is_on_pad(const JawPad& pad, const Eigen::Vector3f& place);

}  // namespace pbdsurg
