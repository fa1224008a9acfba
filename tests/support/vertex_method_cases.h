// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Soft bodies for the vertex-block method, and solvers that move them.

#include <algorithm>
#include <array>

#include "pbdsurg/solver/solver.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// Length of the edges of meshes, m.
inline constexpr double kSoftEdge = 4e-3;

inline Material neo_hookean(float youngs_modulus, float poissons_ratio) {
  Material material;
  material.model = ElasticModel::neo_hookean;
  material.youngs_modulus = youngs_modulus;
  material.poissons_ratio = poissons_ratio;
  return material;
}

inline Material soft_springs(const TetMesh& mesh) {
  return elastic_material(mesh, 1000, 20000, 0.4);
}

/// A bar along x, held at its start.
inline Scene make_bar(const Material& material, std::array<Index, 3> cells = {8, 3, 3},
                      double edge = kSoftEdge) {
  Scene scene;
  scene.add_body("bar", make_box(cells, edge, 0.1), material);
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < 0.5 * edge; });
  return scene;
}

inline SolverOptions vertex_options(int substeps = 10, int iterations = 1, float damping = 0) {
  return {.method = SolverMethod::vertex_block,
          .substeps = substeps,
          .iterations = iterations,
          .damping = damping};
}

/// @return  the report of the last step
inline StepReport run(Solver& solver, int steps, float dt = 5e-3F) {
  StepReport report;
  for (int i = 0; i < steps; ++i) {
    report = solver.step(dt);
  }
  return report;
}

/// The largest distance of a vertex in one solver from where it is in the other, m.
inline float farthest(const Solver& a, const Solver& b) {
  float distance = 0;
  const auto x = a.positions();
  const auto y = b.positions();
  for (std::size_t v = 0; v < x.size(); ++v) {
    distance = std::max(distance, (x[v] - y[v]).norm());
  }
  return distance;
}

}  // namespace pbdsurg::testing
