// SPDX-License-Identifier: Apache-2.0
// Lets a bar sag under its weight by several methods, and measures how far each is from rest.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"

namespace {

using pbdsurg::SolverMethod;
using pbdsurg::SolverOptions;

struct Sag {
  double depth;  // mm, mean over the free end
  double time;   // ms a step
};

Sag sag(const pbdsurg::Scene& scene, SolverOptions options, int steps) {
  options.damping = 20;  // 1/s, so that it comes to rest
  pbdsurg::Solver solver(scene, options);
  const auto start = std::chrono::steady_clock::now();
  for (int step = 0; step < steps; ++step) {
    solver.step(5e-3F);  // s
  }
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  double sum = 0;
  int count = 0;
  for (pbdsurg::Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > 0.019) {
      sum += 1e3 * (scene.positions()[v].y() - positions[v].y());
      ++count;
    }
  }
  return {sum / count, time.count() / steps};
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::TetMesh bar =
      pbdsurg::tetrahedralize(pbdsurg::rounded_box_shape({0, 0, 0}, {0.02, 0.01, 0.01}, 1e-3),
                              options)
          .mesh;
  pbdsurg::Material material;
  material.density = 1060;          // kg/m^3
  material.youngs_modulus = 10e3F;  // Pa
  pbdsurg::Scene scene;
  scene.add_body("bar", bar, material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < -0.018; });

  SolverOptions blocks;
  blocks.method = SolverMethod::vertex_block;
  blocks.substeps = 1;
  blocks.iterations = 200;
  const double rest = sag(scene, blocks, 200).depth;
  std::printf("at rest %.2f mm, after one second:\n", rest);
  const auto compare = [&](const char* name, const SolverOptions& method) {
    const Sag found = sag(scene, method, 200);
    std::printf("%-32s %6.2f mm, %5.1f %% off, %5.2f ms a step\n", name, found.depth,
                100 * std::abs(found.depth / rest - 1), found.time);
  };
  compare("default", {});
  const auto projection = SolverMethod::projection;
  compare("small steps: 10 of 1 sweep", {.method = projection, .substeps = 10, .iterations = 1});
  compare("1 step of 10 sweeps", {.method = projection, .substeps = 1, .iterations = 10});
  blocks.iterations = 10;
  compare("vertex blocks: 1 step of 10", blocks);
  blocks.over_relaxation = 1.7F;
  compare("vertex blocks, over-relaxed", blocks);
} catch (const std::exception& error) {
  std::fprintf(stderr, "method: %s\n", error.what());
  return 2;
}
