// SPDX-License-Identifier: Apache-2.0
// What a cautery costs: an update of 2 ms (one substep: contact, current, heat, changes of
// topology) while a hook of 30 W and 5 mm^2 moves over liver at 10 mm/s, in organs of 20,000 and
// 200,000 tetrahedra with edges of 1 mm; and its ratio to the solver's step between updates, with
// as many threads.
#include <array>
#include <chrono>
#include <cmath>
#include <memory>

#include <benchmark/benchmark.h>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 1e-3;      // m
constexpr double kTimeStep = 2e-3;  // s
constexpr int kUpdates = 250;       // 5 mm

struct Organ {
  Organ(const TetMesh& mesh, int threads) {
    const Executor executor = executor::threads(threads);
    Scene scene;
    const ThermalBody body{scene.add_body("liver", mesh, elastic_material(mesh, 1079, 6e3)),
                           tissues::liver().heat};
    scene.set_gravity(Eigen::Vector3f::Zero());  // the hook goes along the face at rest
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kEdge; });
    solver = std::make_unique<Solver>(scene,
                                      testing::small_steps({.damping = 20, .executor = executor}));
    CauteryOptions options;
    options.heat.executor = options.potential.executor = executor;
    options.potential.region_radii = 5;  // so that the ball fits into both
    cautery = std::make_unique<Cautery>(solver->tissue(), std::span(&body, 1), options);
  }

  std::unique_ptr<Solver> solver;
  std::unique_ptr<Cautery> cautery;
};

void BM_update(benchmark::State& state, const std::array<Index, 3>& cells, int threads) {
  using Clock = std::chrono::steady_clock;
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  const Organ organ(mesh, threads);
  double active = 0, iterations = 0, removed = 0, update_time = 0, step_time = 0;
  int i = 0;
  for (auto _ : state) {
    const double way = 10e-3 * kTimeStep * i++;
    const Eigen::Vector3f tip =
        Eigen::Vector3d(kEdge * cells[0] / 2 - 2.5e-3 + way, kEdge * cells[1] / 2, kEdge * cells[2])
            .cast<float>();
    const Clock::time_point start = Clock::now();
    const CauteryReport report =
        organ.cautery->update(*organ.solver, {tip, tip}, cut_settings(30), kTimeStep);
    const Clock::time_point updated = Clock::now();
    organ.solver->step(static_cast<float>(kTimeStep));
    step_time += std::chrono::duration<double>(Clock::now() - updated).count();
    const double seconds = std::chrono::duration<double>(updated - start).count();
    state.SetIterationTime(seconds);
    update_time += seconds;
    active += static_cast<double>(organ.cautery->field().active_vertices().size());
    iterations += report.potential_iterations;
    removed += static_cast<double>(report.edit.removed_tets.size());
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["tets"] = mesh.tet_count();
  state.counters["active"] = {active, mean};
  state.counters["potential_iterations"] = {iterations, mean};
  state.counters["removed"] = {removed, mean};
  state.counters["solver_ms"] = {1e3 * step_time, mean};
  state.counters["of_solver"] = update_time / step_time;
}

constexpr std::array<Index, 3> kSmall{15, 15, 15}, kLarge{33, 33, 31};

void repeat(benchmark::internal::Benchmark* bench) {
  bench->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(kUpdates);
}

BENCHMARK_CAPTURE(BM_update, 20k_1_thread, kSmall, 1)->Apply(repeat);
BENCHMARK_CAPTURE(BM_update, 20k_2_threads, kSmall, 2)->Apply(repeat);
BENCHMARK_CAPTURE(BM_update, 200k_1_thread, kLarge, 1)->Apply(repeat);
BENCHMARK_CAPTURE(BM_update, 200k_2_threads, kLarge, 2)->Apply(repeat);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
