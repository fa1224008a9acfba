// SPDX-License-Identifier: Apache-2.0
// A step of Neo-Hookean tissue, vertex by vertex against tetrahedron by tetrahedron: the hollow
// mesh of table 2's second row, one rim fixed, 10 substeps of one sweep, one thread.
#include <algorithm>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg::bench {
namespace {

Scene make_scene(float damping) {
  static const TetMesh mesh = table2_mesh(2);
  double start = mesh.positions()[0].x();
  for (const Eigen::Vector3d& x : mesh.positions()) {
    start = std::min(start, x.x());
  }
  Material material;
  material.model = ElasticModel::neo_hookean;
  material.damping = damping;
  Scene scene;
  scene.add_body("gallbladder", mesh, material);
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < start + 4e-3; });
  return scene;
}

void BM_step(benchmark::State& state, SolverMethod method, bool is_serial, float damping) {
  const Executor executor = is_serial ? executor::serial() : executor::threads(1);
  SolverOptions options{.method = method, .executor = executor};
  Solver solver(make_scene(damping), options);
  state.SetLabel(solver.plan().name + ", " + solver.backend_name());
  state.counters["colors"] = static_cast<double>(solver.plan().phases.size());
  for (auto _ : state) {
    solver.step(5e-3F);
  }
  state.counters["time_per_vertex_and_sweep"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * options.substeps * solver.vertex_count(),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

constexpr auto kVertices = SolverMethod::vertex_block;
constexpr auto kTets = SolverMethod::projection;
BENCHMARK_CAPTURE(BM_step, vertices, kVertices, false, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, vertices_damped, kVertices, false, 1e-3F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, vertices_serial, kVertices, true, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, tets, kTets, false, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, tets_damped, kTets, false, 1e-3F)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
