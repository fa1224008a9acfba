// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Soft bodies for the vertex-block method, and solvers that move them.

#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

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

/// A bar of stiff tissue, some of whose tetrahedra are worse than others. Let go from a stretch of
/// 1.3, explicit substeps that are as at rest, or as at the start of a step, make it burst.
inline Scene make_uneven_bar() {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("bar", make_box({8, 3, 3}, 2e-3, 0.1, 5), neo_hookean(2.5e5F, 0.45F));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  return scene;
}

/// m, of all vertices of a scene: longer along x than at rest.
inline std::vector<Eigen::Vector3f> stretched(const Scene& scene, float stretch) {
  std::vector<Eigen::Vector3f> x;
  for (const Eigen::Vector3d& p : scene.positions()) {
    x.emplace_back(p.cast<float>().cwiseProduct(Eigen::Vector3f(stretch, 1, 1)));
  }
  return x;
}

/// At rest, m.
inline std::vector<Index> vertices_above(const Scene& scene, double y) {
  std::vector<Index> found;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].y() > y) {
      found.push_back(v);
    }
  }
  return found;
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
