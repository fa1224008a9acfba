// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A free block of soft tissue, by vertex blocks, for tests of what surfaces do to it.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr float kGravity = 9.81F;    // m/s^2
inline constexpr double kBlockEdge = 5e-3;  // m
inline constexpr std::array<Index, 3> kBlockCells{4, 4, 2};
inline constexpr double kBlockMass = 4e-3;           // kg
inline constexpr float kContactThickness = 0.5e-3F;  // m, between bodies

inline TimeIntegration any_integration() {
  return GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
}

inline SolverOptions vertex_blocks(TimeIntegration integration) {
  return {.method = SolverMethod::vertex_block,
          .integration = integration,
          .executor = executor::serial()};
}

/// Projections by themselves would take hundreds of substeps, which few tests need.
inline SolverOptions quick_options(SolverMethod method, TimeIntegration integration = {},
                                   const Executor& executor = {}) {
  SolverOptions options{.method = method, .integration = integration, .executor = executor};
  if (method == SolverMethod::projection) {
    options.substeps = 100;
    options.iterations = 1;
  }
  return options;
}

inline Material tissue(float stiffness = 20e3F) {
  return {.model = ElasticModel::neo_hookean,
          .youngs_modulus = stiffness,
          .poissons_ratio = 0.4F,
          .damping = 0.01F};
}

inline TetMesh placed_box(std::array<Index, 3> cells, double edge, const Eigen::Affine3d& pose) {
  const TetMesh box = make_box(cells, edge);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& x : box.positions()) {
    positions.push_back(pose * x);
  }
  return {positions, {box.tets().begin(), box.tets().end()}};
}

inline Scene make_free_block(const Eigen::Affine3d& pose = Eigen::Affine3d::Identity()) {
  Scene scene;
  scene.add_body("block", placed_box(kBlockCells, kBlockEdge, pose), tissue());
  scene.set_gravity({0, 0, -kGravity});
  return scene;
}

/// Of a table that is tilted around y, as who lies on it sees it.
inline Eigen::Vector3f gravity_on(float slope) {
  return kGravity * Eigen::Vector3f(std::sin(slope), 0, -std::cos(slope));
}

inline void run(Solver& solver, float step, float seconds) {
  for (int i = 0; i < std::lround(seconds / step); ++i) {
    solver.step(step);
  }
}

inline Eigen::Vector3d mean_of(const Solver& solver, Index first = 0, Index count = 0) {
  const std::vector<Eigen::Vector3f> x = solver.positions();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const Index last = count > 0 ? first + count : solver.vertex_count();
  for (Index v = first; v < last; ++v) {
    sum += x[v].cast<double>();
  }
  return sum / (last - first);
}

}  // namespace pbdsurg::testing
