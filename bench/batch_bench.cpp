// SPDX-License-Identifier: Apache-2.0
// Many copies of a scene stepped at once: the mesh of table 2's second row, paper mode (fractions
// 0.4 and 1, 30 iterations, 0.2 ms), colours by greedy and repair, types separately, one rim fixed,
// each copy started from a stretch of its own. At the end, the first copy and the last must be
// where a solver of one is after as many steps.
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "apps/support/executors.h"
#include "bench/support/paper_step.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

bool has_failed = false;

const Scene& scene() {
  static const Scene row = make_organ_scene(table2_mesh(2));
  return row;
}

SolverOptions options_of(const Executor& executor, DeviceStrategy strategy, Index copies) {
  SolverOptions options = SolverOptions::paper();
  options.coloring = {.repair = true};
  options.copies = copies;
  options.executor = executor;
  options.device_strategy = strategy;
  return options;
}

// @return  m, by 5 to 15 % longer than at rest
std::vector<Eigen::Vector3f> start_of(Index copy, Index copies) {
  const float share = static_cast<float>(copy + 1) / static_cast<float>(copies);
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : scene().positions()) {
    positions.push_back(x.cast<float>());
    positions.back().x() *= 1.05F + 0.1F * share;
  }
  return positions;
}

std::uint64_t hash_alone(const SolverOptions& options, Index copy, Index copies, int steps) {
  SolverOptions alone = options;
  alone.copies = 1;
  Solver solver(scene(), alone);
  solver.write_positions(start_of(copy, copies));
  for (int i = 0; i < steps; ++i) {
    solver.step(kPaperTimeStep);
  }
  return solver.state_hash();
}

void BM_copies(benchmark::State& state, const Executor& executor, DeviceStrategy strategy) {
  const auto copies = static_cast<Index>(state.range(0));
  const SolverOptions options = options_of(executor, strategy, copies);
  Solver solver(scene(), options);
  state.SetLabel(std::string(solver.backend_name()) + "; " + solver.plan().name);
  for (Index copy = 0; copy < copies; ++copy) {
    solver.write_positions(start_of(copy, copies), copy);
  }
  Index lost = solver.step(kPaperTimeStep).non_finite_vertices;  // the first prepares
  std::vector<double> times;                                     // ms
  for (auto _ : state) {
    times.push_back(time_of([&] { lost += solver.step(kPaperTimeStep).non_finite_vertices; }));
    state.SetIterationTime(1e-3 * times.back());
  }
  const int steps = static_cast<int>(times.size()) + 1;
  for (const Index copy : {Index{0}, copies - 1}) {
    if (lost > 0 || solver.state_hash(copy) != hash_alone(options, copy, copies, steps)) {
      state.SkipWithError("a copy is not where it would be alone, or has lost vertices");
      has_failed = true;  // which the exit status of the library does not tell
    }
  }
  const double seconds = 1e-3 * median(times);
  state.counters["copies"] = copies;
  state.counters["median_ms"] = 1e3 * seconds;
  state.counters["p99_ms"] = quantile(times, 0.99);
  state.counters["us_per_copy"] = 1e6 * seconds / copies;
  state.counters["copy_steps_per_second"] = copies / seconds;
  state.counters["tets_per_second"] =
      copies * static_cast<double>(solver.tissue().tets().size()) / seconds;
  state.counters["bytes_per_copy"] = static_cast<double>(solver.memory_bytes()) / copies;
}

void register_copies(const char* name, const Executor& executor, DeviceStrategy strategy,
                     const std::vector<Index>& counts) {
  for (const Index copies : counts) {
    benchmark::RegisterBenchmark((std::string("copies/") + name).c_str(), BM_copies, executor,
                                 strategy)
        ->Arg(copies)
        ->Iterations(copies < 1000 ? 200 : 40)
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
  }
}

// Whether there is a device; says why not.
bool has_device() {
  try {
    static_cast<void>(programs::device());
    return true;
  } catch (const BackendUnavailable& error) {
    std::fprintf(stderr, "no copies on a device: %s\n", error.what());
    return false;
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  using pbdsurg::DeviceStrategy;
  if (pbdsurg::bench::has_device()) {
    const std::vector<pbdsurg::Index> counts{1, 16, 64, 256, 1024};
    pbdsurg::bench::register_copies("cuda", pbdsurg::programs::device(), DeviceStrategy::automatic,
                                    counts);
    pbdsurg::bench::register_copies("cuda_graph", pbdsurg::programs::device(),
                                    DeviceStrategy::graph, counts);
  }
  pbdsurg::bench::register_copies("threaded", pbdsurg::executor::threads(),
                                  DeviceStrategy::automatic, {1, 4});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  return pbdsurg::bench::has_failed ? 1 : 0;
}
