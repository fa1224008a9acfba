// SPDX-License-Identifier: Apache-2.0
// What 5,000 tethers of a program's own cost, on the largest mesh of table 2: steps with and
// without them, in pairs by turns.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/neo_hookean.h"
#include "bench/support/paper_step.h"
#include "bench/support/timing.h"
#include "examples/tether/tethers.h"

namespace pbdsurg::bench {
namespace {

constexpr int kTethers = 5000;

const TetMesh& mesh() {
  static const TetMesh row = table2_mesh(5);
  return row;
}

// Each from a vertex of an edge to the other, at a tenth less than its length: all are taut.
std::shared_ptr<Tethers> make_tethers(const Solver& solver) {
  const auto edges = solver.tissue().edges();
  const auto x = solver.positions();
  std::vector<Tether> tethers;
  for (int i = 0; i < kTethers; ++i) {
    const auto e =
        static_cast<std::size_t>(random_bits(1, static_cast<std::uint64_t>(i))) % edges.size();
    const auto [a, b] = edges[e];
    tethers.push_back(
        {.vertex = a, .other = b, .length = 0.9F * (x[a] - x[b]).norm(), .compliance = 0.1F});
  }
  std::ranges::sort(tethers, {}, &Tether::vertex);  // as a program lists them that walks a mesh
  return std::make_shared<Tethers>(std::move(tethers));
}

void run_pairs(benchmark::State& state, const Scene& scene, const SolverOptions& options,
               float dt) {
  Solver plain(scene, options), tethered(scene, options);
  tethered.add_constraints(make_tethers(tethered));
  state.SetLabel(std::string(plain.backend_name()) + "; " + plain.plan().name);
  std::vector<double> with, without;
  for (auto _ : state) {
    without.push_back(time_of([&] { plain.step(dt); }));
    with.push_back(time_of([&] { tethered.step(dt); }));
  }
  constexpr double kShare = 0.1;  // of turns, which others on the machine disturb the least
  const double base = quantile(without, kShare), all = quantile(with, kShare);
  state.counters["step_ms"] = base;
  state.counters["with_tethers_ms"] = all;
  state.counters["share_percent"] = 100 * (all / base - 1);
}

// The paper's step, of 30 sweeps.
void BM_fractions(benchmark::State& state, const Executor& executor) {
  SolverOptions options = SolverOptions::paper();
  options.composition = PlanComposition::nested;
  options.executor = executor;
  run_pairs(state, make_organ_scene(mesh()), options, kPaperTimeStep);
}

// Of 5 ms, on soft tissue.
void BM_default(benchmark::State& state, const Executor& executor) {
  Scene scene;
  scene.add_body("organ", mesh(), neo_hookean(10e3, 0.4));
  const double middle = bounding_box(mesh()).center().x();
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < middle; });
  run_pairs(state, scene, {.executor = executor}, 5e-3F);
}

BENCHMARK_CAPTURE(BM_fractions, serial, executor::serial())
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20);
BENCHMARK_CAPTURE(BM_fractions, one_thread, executor::threads(1))
    ->Unit(benchmark::kMillisecond)
    ->Iterations(40);
BENCHMARK_CAPTURE(BM_fractions, two_threads, executor::threads(2))
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(40);
BENCHMARK_CAPTURE(BM_default, one_thread, executor::threads(1))
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20);
BENCHMARK_CAPTURE(BM_default, two_threads, executor::threads(2))
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(20);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
