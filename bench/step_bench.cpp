// SPDX-License-Identifier: Apache-2.0
// The serial step against a plain loop over the same constraints: the mesh of table 2's second row,
// paper mode (fractions 0.4 and 1, 30 iterations, 0.2 ms), one rim fixed, stretched by 10 %.
#include <cstdint>
#include <string>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/paper_step.h"
#include "bench/support/plain_loop.h"

namespace pbdsurg::bench {
namespace {

const TetMesh& mesh() {
  static const TetMesh row = table2_mesh(2);
  return row;
}

void report_work(benchmark::State& state, std::size_t edges) {
  state.counters["edges"] = static_cast<double>(edges);
  state.counters["tets"] = mesh().tet_count();
  state.counters["time_per_projection"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * PlainLoop::kIterations *
                             (static_cast<double>(edges) + mesh().tet_count()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void run_steps(benchmark::State& state, const SolverOptions& options) {
  const Scene scene = make_organ_scene(mesh());
  Solver solver(scene, options);
  state.SetLabel(std::string(solver.backend_name()) + "; " + solver.plan().name);
  state.counters["bytes_per_tet"] = static_cast<double>(solver.memory_bytes()) /
                                    static_cast<double>(solver.tissue().tets().size());
  state.counters["colors"] = static_cast<double>(solver.plan().phases.size());
  solver.write_positions(stretched_positions(scene));
  const Snapshot start = solver.snapshot();
  solver.step(kPaperTimeStep);
  const std::uint64_t expected = solver.state_hash();
  for (auto _ : state) {
    state.PauseTiming();
    solver.restore(start);
    state.ResumeTiming();
    solver.step(kPaperTimeStep);
  }
  if (solver.state_hash() != expected) {
    state.SkipWithError("the end state differs from that of the first run");
  }
  report_work(state, solver.tissue().edges().size());
}

void BM_serial_step(benchmark::State& state, PlanComposition composition) {
  SolverOptions options = SolverOptions::paper();
  options.executor = executor::serial();
  options.composition = composition;
  run_steps(state, options);
}

// @param threads  0 for one a processor
void BM_threaded_step(benchmark::State& state, PlanComposition composition, int threads,
                      MathMode math) {
  SolverOptions options = SolverOptions::paper();
  options.composition = composition;
  options.executor = executor::threads(threads);
  options.math = math;
  run_steps(state, options);
}

void BM_plain_loop(benchmark::State& state, PlainLoop::Order order) {
  PlainLoop loop(make_organ_scene(mesh()), order);
  for (auto _ : state) {
    state.PauseTiming();
    loop.restart();
    state.ResumeTiming();
    loop.step();
  }
  if (!loop.is_finite()) {
    state.SkipWithError("the end state is not finite");
  }
  report_work(state, loop.link_count());
}

BENCHMARK_CAPTURE(BM_serial_step, separate, PlanComposition::separate)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_serial_step, joint, PlanComposition::joint)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_threaded_step, separate_one_thread, PlanComposition::separate, 1,
                  MathMode::fast)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_threaded_step, nested_one_thread, PlanComposition::nested, 1, MathMode::fast)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_threaded_step, nested_one_thread_strict, PlanComposition::nested, 1,
                  MathMode::strict)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_threaded_step, nested_all_threads, PlanComposition::nested, 0, MathMode::fast)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_plain_loop, links_sorted, PlainLoop::sorted)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_plain_loop, links_shuffled, PlainLoop::shuffled)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_plain_loop, links_colored, PlainLoop::colored)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
