// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Blocks of tissue and what is done to them.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg::bench {

inline constexpr float kCaseStep = 5e-3F;  ///< s
inline constexpr float kGravity = 9.81F;   ///< m/s^2
inline constexpr ToolSurface kSmooth{ContactFeatures::all, 0};

/// A block below z = 0 whose edges grow from the origin outwards, each by a quarter.
struct GradedBlock {
  double edge;        ///< m, of cubes near the origin
  double fine;        ///< m: as far from it they do not grow
  double half_width;  ///< m, at least
  double depth;       ///< m, at least
};

[[nodiscard]] TetMesh make_graded_block(const GradedBlock& block);

[[nodiscard]] std::vector<Index> vertices_below(const Scene& scene, double z);

[[nodiscard]] ToolPose at(const Eigen::Vector3f& place);

/// m
[[nodiscard]] Eigen::Vector3d center_of(const Solver& solver);

/// Steps until nothing moves faster than 2 um/s, at most for a time.
/// @param most  s
void settle(Solver& solver, double most);

/// Moves a tool along -z within a quarter of a second, then settles.
/// @param depth  m
void press(Solver& solver, ToolId tool, const Eigen::Vector3f& touch, double depth);

/// m, of tissue in a tool: the largest.
[[nodiscard]] double overlap_of(const Solver& solver, ToolId tool);

}  // namespace pbdsurg::bench
