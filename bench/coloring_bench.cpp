// SPDX-License-Identifier: Apache-2.0
// Colouring on one CPU thread: time, colours beside the clique bound, deviation; and Boost Graph's
// greedy colouring of the same constraints in the same run, with and without building its graph.
#include <benchmark/benchmark.h>

#include "coloring_samples.h"
#ifdef PBDSURG_HAS_BOOST_GRAPH
#include "boost_coloring.h"
#endif

namespace pbdsurg::bench {
namespace {

void color(benchmark::State& state, const ColoringSample& sample, const ColoringOptions& options) {
  const ConstraintVertices constraints = sample.constraints();
  Coloring coloring;
  for (auto _ : state) {
    coloring = color_constraints(constraints, options);
  }
  report_coloring(state, constraints, coloring);
}

#ifdef PBDSURG_HAS_BOOST_GRAPH
void color_by_boost(benchmark::State& state, const ColoringSample& sample, bool with_graph) {
  const ConstraintVertices constraints = sample.constraints();
  Coloring coloring;
  if (with_graph) {
    for (auto _ : state) {
      coloring = BoostColoring(constraints).color();
    }
  } else {
    const BoostColoring graph(constraints);
    for (auto _ : state) {
      coloring = graph.color();
    }
  }
  report_coloring(state, constraints, coloring);
}
#endif

// A second or more for a million.
bool takes_long(const ColoringOptions& options) {
  return options.algorithm == ColoringAlgorithm::luby ||
         (options.algorithm == ColoringAlgorithm::random_disc && options.repair) ||
         options.order == GreedyOrder::smallest_last || options.order == GreedyOrder::saturation;
}

void register_all() {
  std::vector<NamedColoring> colorings = parallel_colorings();
  for (const GreedyOrder order :
       {GreedyOrder::largest_valence, GreedyOrder::smallest_last, GreedyOrder::saturation}) {
    ColoringOptions options;
    options.order = order;
    colorings.push_back({std::string("greedy:") + name_of(order), options});
  }
  for (const ColoringSample& sample : coloring_samples()) {
    for (const NamedColoring& coloring : colorings) {
      auto* const bench = benchmark::RegisterBenchmark(
          (sample.name() + "/" + coloring.name).c_str(), color, sample, coloring.options);
      bench->Unit(benchmark::kMillisecond)->MinTime(0.1);
      if (sample.tets >= 1'000'000 && takes_long(coloring.options)) {
        bench->Repetitions(1);
      }
    }
#ifdef PBDSURG_HAS_BOOST_GRAPH
    for (const bool with_graph : {false, true}) {
      benchmark::RegisterBenchmark(
          (sample.name() + "/boost_greedy" + (with_graph ? "+graph" : "")).c_str(), color_by_boost,
          sample, with_graph)
          ->Unit(benchmark::kMillisecond)
          ->MinTime(0.1);
    }
#endif
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  pbdsurg::bench::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
}
