// SPDX-License-Identifier: Apache-2.0
// Time and quality of the two ways to divide vertices, on hollow rows of table 2: the share of
// distances and volumes whose vertices lie in more than one part, and the largest part over the
// mean. Four parts are the domains of row 5 in a nested plan, sixteen the blocks of a cluster.
#include <algorithm>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/mesh/partition.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {
namespace {

void run(benchmark::State& state, PartitionMethod method) {
  const TetMesh mesh = table2_mesh(static_cast<int>(state.range(0)));
  const std::vector<Edge> edges = find_edges(mesh.tets());
  const auto part_count = static_cast<Index>(state.range(1));
  Partition partition;
  for (auto _ : state) {
    partition = partition_vertices(edges, mesh.positions(), part_count, method);
    benchmark::DoNotOptimize(partition.part_of_vertex.data());
  }
  const std::vector<Index>& part_of = partition.part_of_vertex;
  const auto crosses = [&](const auto& vertices) {
    return std::ranges::any_of(vertices,
                               [&](Index v) { return part_of[v] != part_of[vertices[0]]; });
  };
  const auto crossing =
      std::ranges::count_if(edges, crosses) + std::ranges::count_if(mesh.tets(), crosses);
  std::vector<Index> sizes(static_cast<std::size_t>(part_count), 0);
  for (const Index part : part_of) {
    ++sizes[part];
  }
  state.SetLabel(std::string(partition.method));
  state.counters["crossing_percent"] = 100.0 * static_cast<double>(crossing) /
                                       static_cast<double>(edges.size() + mesh.tets().size());
  state.counters["largest_over_mean"] =
      static_cast<double>(std::ranges::max(sizes)) * part_count / mesh.vertex_count();
}

void BM_recursive_bisection(benchmark::State& state) {
  run(state, PartitionMethod::recursive_bisection);
}
BENCHMARK(BM_recursive_bisection)->ArgsProduct({{2, 5}, {2, 4, 16}})->Unit(benchmark::kMillisecond);

void BM_best(benchmark::State& state) {
  run(state, PartitionMethod::best);
}
BENCHMARK(BM_best)->ArgsProduct({{2, 5}, {2, 4, 16}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
