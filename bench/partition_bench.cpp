// SPDX-License-Identifier: Apache-2.0
// Time and quality of the two ways to divide vertices: how many edges each cuts, of a box of
// lattice points about as large as the paper's meshes.
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/mesh/partition.h"

namespace pbdsurg {
namespace {

constexpr int kNx = 40, kNy = 20, kNz = 10;

struct Lattice {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Edge> edges;  // to the neighbours of larger id, diagonals of the cells included
};

Lattice make_lattice() {
  Lattice lattice;
  for (int z = 0; z < kNz; ++z) {
    for (int y = 0; y < kNy; ++y) {
      for (int x = 0; x < kNx; ++x) {
        const auto id = static_cast<Index>(lattice.positions.size());
        lattice.positions.push_back(2e-3 * Eigen::Vector3d(x, y, z));
        for (int step = 1; step < 8; ++step) {
          const int dx = step & 1, dy = (step >> 1) & 1, dz = step >> 2;
          if (x + dx < kNx && y + dy < kNy && z + dz < kNz) {
            lattice.edges.push_back({id, id + dx + kNx * (dy + kNy * dz)});
          }
        }
      }
    }
  }
  return lattice;
}

void run(benchmark::State& state, PartitionMethod method) {
  const Lattice lattice = make_lattice();
  const auto part_count = static_cast<Index>(state.range(0));
  Partition partition;
  for (auto _ : state) {
    partition = partition_vertices(lattice.edges, lattice.positions, part_count, method);
    benchmark::DoNotOptimize(partition.part_of_vertex.data());
  }
  state.SetLabel(std::string(partition.method));
  state.counters["cut_edges"] = partition.cut_edges;
  state.counters["cut_percent"] =
      100.0 * partition.cut_edges / static_cast<double>(lattice.edges.size());
}

void BM_recursive_bisection(benchmark::State& state) {
  run(state, PartitionMethod::recursive_bisection);
}
BENCHMARK(BM_recursive_bisection)->Arg(4)->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond);

void BM_best(benchmark::State& state) {
  run(state, PartitionMethod::best);
}
BENCHMARK(BM_best)->Arg(4)->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
