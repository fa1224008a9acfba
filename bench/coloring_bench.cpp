// SPDX-License-Identifier: Apache-2.0
// Colouring on one CPU thread: time, colours beside the clique bound, deviation; clusters, vertex
// blocks, ownership of edges and a limit on the colours of tetrahedra; and Boost Graph's
// greedy colouring of the same constraints in the same run, with and without building its graph.
// Vertex blocks of the hollow meshes of table 2, too, and each step by which a solver colours them.
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/clusters.h"
#include "pbdsurg/coloring/edge_ownership.h"
#include "pbdsurg/coloring/repair.h"

#include "bench/support/coloring_samples.h"
#include "lib/coloring/fewer_colors.h"
#ifdef PBDSURG_HAS_BOOST_GRAPH
#include "bench/support/boost_coloring.h"
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

void color_clusters(benchmark::State& state, const ColoringSample& sample, Index size) {
  const ConstraintVertices constraints = sample.constraints();
  ConstraintClusters clusters;
  Coloring coloring;
  for (auto _ : state) {
    clusters = cluster_constraints(constraints, size);
    coloring = color_greedy({clusters.vertices, constraints.vertex_count}, GreedyOrder::saturation);
  }
  report_coloring(state, {clusters.vertices, constraints.vertex_count}, coloring);
}

enum class VertexColoring { saturation, repaired, searched };

void color_blocks(benchmark::State& state, const ConstraintVertices& constraints,
                  VertexColoring how) {
  IndexLists blocks;
  Coloring coloring;
  for (auto _ : state) {
    blocks = find_vertex_constraints(constraints);
    const ConstraintVertices vertices(blocks, constraints.constraint_count());
    coloring = color_constraints(
        vertices, {.order = GreedyOrder::saturation, .repair = how != VertexColoring::saturation});
    if (how == VertexColoring::searched) {
      find_fewer_colors(coloring, vertices, 0);
    }
  }
  report_coloring(state, {blocks, constraints.constraint_count()}, coloring);
}

void color_vertices(benchmark::State& state, const ColoringSample& sample, VertexColoring how) {
  color_blocks(state, sample.constraints(), how);
}

void color_row(benchmark::State& state, int row, VertexColoring how) {
  const TetMesh mesh = table2_mesh(row);
  color_blocks(state, {mesh.tets(), mesh.vertex_count()}, how);
}

void own_edges(benchmark::State& state, const ColoringSample& sample) {
  const SampleMesh& mesh = sample_mesh(sample.kind, sample.tets);
  const auto tet_edges = find_tet_edges(mesh.mesh.tets, mesh.edges);
  EdgeOwnership ownership;
  for (auto _ : state) {
    ownership = assign_edges_to_tets(static_cast<Index>(mesh.edges.size()), tet_edges);
  }
  state.counters["edges"] = static_cast<double>(mesh.edges.size());
  state.counters["max_owned"] = ownership.max_owned;
}

void limit_to_half(benchmark::State& state, const ColoringSample& sample) {
  const ConstraintVertices constraints = sample.constraints();
  const Coloring start = color_greedy(constraints);
  Coloring coloring;
  for (auto _ : state) {
    coloring = start;
    limit_colors(coloring, constraints, (start.color_count + 1) / 2);
  }
  report_coloring(state, constraints, coloring);
  state.counters["overflow"] = measure_coloring(coloring, constraints).overflow;
}

constexpr std::pair<const char*, VertexColoring> kVertexColorings[] = {
    {"vertices", VertexColoring::saturation},
    {"vertices+repair", VertexColoring::repaired},
    {"vertices+repair+search", VertexColoring::searched}};

// Fewer phases than one a colour of tetrahedra.
void register_reductions(const ColoringSample& sample) {
  const auto add = [&](const std::string& name, const auto& run, auto... arguments) {
    benchmark::RegisterBenchmark((sample.name() + "/" + name).c_str(), run, sample, arguments...)
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.1);
  };
  for (const Index size : {2, 4, 8, 16}) {
    add("clusters:" + std::to_string(size), color_clusters, size);
  }
  for (const auto& [name, how] : kVertexColorings) {
    add(name, color_vertices, how);
  }
  add("edge_ownership", own_edges);
  add("limit_to_half", limit_to_half);
}

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
    if (!sample.edges) {
      register_reductions(sample);
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
  for (int row = 1; row <= static_cast<int>(kTable2.size()); ++row) {
    for (const auto& [name, how] : kVertexColorings) {
      benchmark::RegisterBenchmark(("table2/" + std::to_string(row) + "/" + name).c_str(),
                                   color_row, row, how)
          ->Unit(benchmark::kMillisecond)
          ->MinTime(0.1);
    }
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
