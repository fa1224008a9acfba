// SPDX-License-Identifier: Apache-2.0
// What a cautery costs: an update of 2 ms (one substep: contact, current, heat, changes of
// topology) while a hook of 30 W and 5 mm^2 moves over liver at 10 mm/s, in organs of 20,000 and
// 200,000 tetrahedra with edges of 1 mm; and a step of the solver beside it.
#include <array>
#include <cmath>
#include <memory>

#include <benchmark/benchmark.h>

#include "pbdsurg/surgery/cautery.h"

#include "support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 1e-3;      // m
constexpr double kTimeStep = 2e-3;  // s
constexpr int kUpdates = 250;       // 5 mm, then a fresh organ

struct Organ {
  Organ(const TetMesh& mesh, int threads) {
    Scene scene;
    const ThermalBody body{scene.add_body("liver", mesh, elastic_material(mesh, 1079, 6e3)), &mesh,
                           kLiver};
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kEdge; });
    solver = std::make_unique<Solver>(scene, SolverOptions{.damping = 20, .threads = threads});
    CauteryOptions options;
    options.heat.threads = options.potential.threads = threads;
    options.potential.region_radii = 5;  // so that the ball fits into both
    cautery = std::make_unique<Cautery>(*solver, std::span(&body, 1), options);
  }

  std::unique_ptr<Solver> solver;
  std::unique_ptr<Cautery> cautery;
};

void BM_update(benchmark::State& state, const std::array<Index, 3>& cells, int threads) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  auto organ = std::make_unique<Organ>(mesh, threads);
  double active = 0, iterations = 0, removed = 0;
  int i = 0;
  for (auto _ : state) {
    if (i == kUpdates) {
      state.PauseTiming();
      organ = std::make_unique<Organ>(mesh, threads);
      i = 0;
      state.ResumeTiming();
    }
    const double way = 10e-3 * kTimeStep * i++;
    const Eigen::Vector3f tip =
        Eigen::Vector3d(kEdge * cells[0] / 2 - 2.5e-3 + way, kEdge * cells[1] / 2, kEdge * cells[2])
            .cast<float>();
    const CauteryReport report =
        organ->cautery->update(*organ->solver, {tip, tip}, cut_settings(30), kTimeStep);
    active += static_cast<double>(organ->cautery->field().active_vertices().size());
    iterations += report.potential_iterations;
    removed += static_cast<double>(report.edit.tets.size());
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["tets"] = mesh.tet_count();
  state.counters["active"] = {active, mean};
  state.counters["potential_iterations"] = {iterations, mean};
  state.counters["removed"] = {removed, mean};
}

void BM_solver_step(benchmark::State& state, const std::array<Index, 3>& cells, int threads) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  const Organ organ(mesh, threads);
  for (auto _ : state) {
    organ.solver->step(static_cast<float>(kTimeStep));
  }
}

constexpr std::array<Index, 3> kSmall{15, 15, 15}, kLarge{33, 33, 31};
BENCHMARK_CAPTURE(BM_update, 20k_1_thread, kSmall, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_update, 20k_2_threads, kSmall, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_update, 200k_1_thread, kLarge, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_update, 200k_2_threads, kLarge, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_solver_step, 20k_2_threads, kSmall, 2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
