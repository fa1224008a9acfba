// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Counts how often a sweep projects each constraint, whatever the order of the plan.
///
/// Constraints thousands of times softer than their vertices are mobile hardly feel each other: a
/// projection moves momentum by C / (m + a), and a sweep that projects each constraint once gives
/// each vertex the sum of what its constraints give alone.

#include <algorithm>
#include <limits>
#include <vector>

#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {

inline constexpr float kSoftTimeStep = 1e-3F;        // s
inline constexpr Stiffness kSoftStretch{1, 200};     // m/N
inline constexpr Stiffness kSoftVolume{1, 4.8e-9F};  // m^5/N, for impulses like those of edges

/// A block with volume constraints, a tube without, and links between them.
inline Scene make_soft_scene() {
  Scene scene;
  const Material block{
      .model = ElasticModel::springs, .stretch = kSoftStretch, .volume = kSoftVolume};
  Material tube = block;
  tube.has_volume_constraints = false;
  scene.add_body("tube", make_box({3, 1, 1}, kSoftEdge, 0.1, 2), tube);
  scene.add_body("block", make_box({3, 3, 3}, kSoftEdge, 0.1), block);
  for (Index v = 0; v < scene.body(0).vertex_count; ++v) {
    scene.add_link({v, scene.body(1).first_vertex + v, 0, {1, 200}});
  }
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

/// @param coloring  and composition: of the plan to be tested
inline SolverOptions soft_options(const ColoringOptions& coloring, PlanComposition composition) {
  return small_steps({.substeps = 1, .coloring = coloring, .composition = composition});
}

/// Stretches the scene, makes one sweep and compares.
/// @return  the largest difference of a vertex's momentum from the sum, as a share of the smallest
///          that one constraint gives: 1 or more when one is left out or projected twice
inline double count_error(Solver& solver, const Scene& scene) {
  std::vector<Eigen::Vector3f> start;
  for (const Eigen::Vector3d& x : scene.positions()) {
    start.push_back((1.1 * x).cast<float>());
  }
  solver.write_positions(start);
  std::vector<double> mass(start.size(), 0);
  const double density = scene.body(0).material.density;
  for (std::size_t t = 0; t < scene.tets().size(); ++t) {
    for (const Index v : scene.tets()[t]) {
      mass[v] += solver.tissue().is_tet_alive(static_cast<Index>(t))
                     ? density * tet_volume(scene.positions(), scene.tets()[t]) / 4
                     : 0;
    }
  }

  std::vector<Eigen::Vector3d> expected(start.size(), Eigen::Vector3d::Zero());
  double smallest = std::numeric_limits<double>::max();
  const auto project = [&]<std::size_t kArity>(auto constraint,
                                               const std::array<Index, kArity>& vertices,
                                               double rest, double compliance) {
    Vec3<double> x[kArity], moved[kArity];
    double w[kArity];
    for (std::size_t k = 0; k < kArity; ++k) {
      const Eigen::Vector3f& p = start[vertices[k]];
      x[k] = moved[k] = {p.x(), p.y(), p.z()};
      w[k] = 1 / mass[vertices[k]];
    }
    const double parameters[] = {rest, compliance, 0};
    const Substep<double> substep{1 / double{kSoftTimeStep},
                                  1 / (double{kSoftTimeStep} * kSoftTimeStep)};
    double multiplier[] = {0};
    decltype(constraint)::template project<ProjectionMode::compliance>(moved, w, parameters,
                                                                       substep, multiplier);
    for (std::size_t k = 0; k < kArity; ++k) {
      const Vec3<double> d = mass[vertices[k]] * (moved[k] - x[k]);
      expected[vertices[k]] += Eigen::Vector3d(d.x, d.y, d.z);
      smallest = std::min(smallest, Eigen::Vector3d(d.x, d.y, d.z).norm());
    }
  };
  for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    if (solver.tissue().is_edge_alive(e)) {
      project(DistanceConstraint{}, solver.tissue().edges()[e], solver.rest_length(e),
              kSoftStretch.compliance);
    }
  }
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    if (solver.tissue().is_link_alive(l)) {
      const Link& link = solver.tissue().links()[l];
      project(DistanceConstraint{}, Edge{link.first, link.second}, link.rest_length,
              link.stiffness.compliance);
    }
  }
  const Body& block = scene.body(1);
  for (Index t = block.first_tet; t < block.first_tet + block.tet_count; ++t) {
    if (solver.tissue().is_tet_alive(t)) {
      project(VolumeConstraint{}, solver.tissue().tets()[t], solver.rest_volume(t),
              kSoftVolume.compliance);
    }
  }

  solver.step(kSoftTimeStep);
  const std::vector<Eigen::Vector3f> after = solver.positions();
  double farthest = 0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    const Eigen::Vector3d given = mass[v] * (after[v] - start[v]).cast<double>();
    farthest = std::max(farthest, (given - expected[v]).norm());
  }
  return farthest / smallest;
}

}  // namespace pbdsurg::testing
