// SPDX-License-Identifier: Apache-2.0
// What 200 edits of one hundredth each leave of a colouring of tetrahedra, and what they cost:
// removed are tetrahedra at random (scattered) or neighbours of each other (regional), and put back
// are those that the edit before removed. Meshes:
//
//   surface_filled/ROW  of table 2, the paper's kind; needs the program tetgen
//   hollow/ROW          of table 2, as this library makes them
//   split/TETS          a box whose edges are split at random, with all tetrahedra around them,
//   until
//                       it has five times as many: very irregular, a hundred tetrahedra at a vertex
//   lattice/SIDE        that box unsplit, 24 tetrahedra at each inner vertex: the hard case
//
// Counters: colours at the start and the most after any edit; clique bound of the mesh; deviation
// of the colours' sizes in the end (rsd) and the largest after any edit; the time of an edit,
// checks and removals included, for each constraint inserted; constraints recoloured for each
// inserted.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/dynamic_coloring.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/core/random.h"

namespace pbdsurg {
namespace {

constexpr int kEdits = 200;

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(seed) {}
  Index below(std::size_t count) { return static_cast<Index>(random_bits(seed_, next_++) % count); }

 private:
  std::uint64_t seed_;
  std::uint64_t next_ = 0;
};

struct Tets {
  std::vector<Tet> tets;
  Index vertex_count = 0;

  [[nodiscard]] ConstraintVertices view() const { return view(tets); }
  [[nodiscard]] ConstraintVertices view(const std::vector<Tet>& some) const {
    return {std::span<const Tet>(some), vertex_count};
  }
};

Tets make_table2(int row, Table2Kind kind) {
  const TetMesh mesh = table2_mesh(row, kind);
  return {{mesh.tets().begin(), mesh.tets().end()}, mesh.vertex_count()};
}

// A box of side^3 cubes of six tetrahedra; its edges are split until there are as many as wanted.
Tets make_box(Index side, Index wanted) {
  Tets mesh;
  const auto vertex = [&](const std::array<Index, 3>& p) {
    return p[0] + (side + 1) * (p[1] + (side + 1) * p[2]);
  };
  mesh.vertex_count = (side + 1) * (side + 1) * (side + 1);
  std::array<Index, 3> cube{};
  for (cube[2] = 0; cube[2] < side; ++cube[2]) {
    for (cube[1] = 0; cube[1] < side; ++cube[1]) {
      for (cube[0] = 0; cube[0] < side; ++cube[0]) {
        std::array<int, 3> path{0, 1, 2};
        do {
          auto corner = cube;
          Tet tet{vertex(corner), 0, 0, 0};
          for (int i = 0; i < 3; ++i) {
            ++corner[path[i]];
            tet[i + 1] = vertex(corner);
          }
          mesh.tets.push_back(tet);
        } while (std::next_permutation(path.begin(), path.end()));
      }
    }
  }
  std::vector<std::vector<Index>> around(static_cast<std::size_t>(mesh.vertex_count));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) {
      around[v].push_back(static_cast<Index>(t));
    }
  }
  Dice dice(7);
  while (static_cast<Index>(mesh.tets.size()) < wanted) {
    const Tet chosen = mesh.tets[dice.below(mesh.tets.size())];
    const Index from = dice.below(4);
    const Index a = chosen[from];
    const Index b = chosen[(from + 1 + dice.below(3)) % 4];
    const Index middle = mesh.vertex_count++;
    around.emplace_back();
    std::vector<Index> kept_at_b;
    for (const Index t : around[b]) {
      Tet& tet = mesh.tets[t];
      if (std::find(tet.begin(), tet.end(), a) == tet.end()) {
        kept_at_b.push_back(t);
        continue;
      }
      // t keeps a; a new tetrahedron has b
      const auto added = static_cast<Index>(mesh.tets.size());
      Tet other = tet;
      std::replace(tet.begin(), tet.end(), b, middle);
      std::replace(other.begin(), other.end(), a, middle);
      around[middle].push_back(t);
      for (const Index v : other) {
        (v == b ? kept_at_b : around[v]).push_back(added);
      }
      mesh.tets.push_back(other);
    }
    around[b] = std::move(kept_at_b);
  }
  return mesh;
}

DynamicColoring color_all(const Tets& mesh) {
  DynamicColoring coloring(mesh.view({}), {});
  ConstraintEdit edit;
  edit.inserted = mesh.view();
  coloring.apply(edit);
  return coloring;
}

// Which tetrahedra an edit removes.
class Chooser {
 public:
  Chooser(const Tets& mesh, bool regional)
      : around_(find_vertex_constraints(mesh.view())), regional_(regional), dice_(3) {}

  std::vector<Index> choose(const Tets& mesh, const std::vector<bool>& gone) {
    const std::size_t wanted = mesh.tets.size() / 100;
    std::vector<bool> chosen(mesh.tets.size(), false);
    std::vector<Index> result;
    const auto take = [&](Index t) {
      if (!gone[t] && !chosen[t] && result.size() < wanted) {
        chosen[t] = true;
        result.push_back(t);
      }
    };
    while (result.size() < wanted) {
      const Index start = dice_.below(mesh.tets.size());
      take(start);
      // a region grows tetrahedron by tetrahedron
      for (std::size_t next = result.size() - 1;
           regional_ && next < result.size() && result.size() < wanted; ++next) {
        for (const Index v : mesh.tets[result[next]]) {
          for (const Index t : around_[v]) {
            take(t);
          }
        }
      }
    }
    return result;
  }

 private:
  IndexLists around_;
  bool regional_;
  Dice dice_;
};

void run_edits(benchmark::State& state, const Tets& mesh, bool regional) {
  Index bound = 0;
  Index start_colors = 0;
  Index colors = 0;
  double deviation = 0;
  double peak = 0;
  std::size_t inserted = 0;
  std::size_t recolored = 0;
  double seconds = 0;
  for (auto _ : state) {
    DynamicColoring coloring = color_all(mesh);
    start_colors = coloring.color_count();
    bound = coloring.clique_bound();
    Chooser chooser(mesh, regional);
    std::vector<Index> id_of(mesh.tets.size());
    std::iota(id_of.begin(), id_of.end(), 0);
    std::vector<bool> gone(mesh.tets.size(), false);
    std::vector<Index> out;  // what the edit before has removed
    double total = 0;
    for (int i = 0; i < kEdits; ++i) {
      const std::vector<Index> chosen = chooser.choose(mesh, gone);
      std::vector<Index> removed;
      std::vector<Tet> back;
      for (const Index t : chosen) {
        removed.push_back(id_of[t]);
        gone[t] = true;
      }
      for (const Index t : out) {
        back.push_back(mesh.tets[t]);
        gone[t] = false;
      }
      const ConstraintEdit edit{removed, {}, mesh.view(back)};
      const auto start = std::chrono::steady_clock::now();
      const ColoringUpdate update = coloring.apply(edit);
      total += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      for (std::size_t k = 0; k < out.size(); ++k) {
        id_of[out[k]] = update.inserted[k];
      }
      inserted += out.size();
      recolored += update.recolored.size();
      colors = std::max(colors, coloring.color_count());
      peak = std::max(peak, coloring.relative_deviation());
      out = chosen;
    }
    deviation = coloring.relative_deviation();
    const ColoringExtract extract = coloring.extract();
    if (find_conflict(extract.coloring, extract.constraints())) {
      state.SkipWithError("the colouring is not valid");
      return;
    }
    state.SetIterationTime(total);
    seconds += total;
  }
  state.counters["tets"] = static_cast<double>(mesh.tets.size());
  state.counters["clique_bound"] = bound;
  state.counters["start_colors"] = start_colors;
  state.counters["colors"] = colors;
  state.counters["rsd"] = deviation;
  state.counters["peak_rsd"] = peak;
  state.counters["us_per_insertion"] = 1e6 * seconds / static_cast<double>(inserted);
  state.counters["recolored"] = static_cast<double>(recolored) / static_cast<double>(inserted);
}

void BM_table2(benchmark::State& state, Table2Kind kind, bool regional) {
  try {
    run_edits(state, make_table2(static_cast<int>(state.range(0)), kind), regional);
  } catch (const BackendUnavailable& error) {
    state.SkipWithError(error.what());
  }
}
void BM_split(benchmark::State& state, bool regional) {
  const auto wanted = static_cast<Index>(state.range(0));
  run_edits(state, make_box(static_cast<Index>(std::cbrt(wanted / 30)), wanted), regional);
}
void BM_lattice(benchmark::State& state, bool regional) {
  run_edits(state, make_box(static_cast<Index>(state.range(0)), 0), regional);
}

void rows(benchmark::internal::Benchmark* bench) {
  bench->Arg(1)->Arg(2)->Arg(5)->UseManualTime()->Unit(benchmark::kMillisecond);
}
void sizes(benchmark::internal::Benchmark* bench) {
  for (const int tets : {10'000, 60'000, 250'000, 1'000'000}) {
    bench->Arg(tets);
  }
  bench->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(BM_table2, surface_filled_scattered, Table2Kind::surface_filled, false)
    ->Apply(rows);
BENCHMARK_CAPTURE(BM_table2, surface_filled_regional, Table2Kind::surface_filled, true)
    ->Apply(rows);
BENCHMARK_CAPTURE(BM_table2, hollow_scattered, Table2Kind::hollow, false)->Apply(rows);
BENCHMARK_CAPTURE(BM_table2, hollow_regional, Table2Kind::hollow, true)->Apply(rows);
BENCHMARK_CAPTURE(BM_lattice, scattered, false)
    ->Arg(15)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_lattice, regional, true)
    ->Arg(15)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_split, scattered, false)->Apply(sizes);
BENCHMARK_CAPTURE(BM_split, regional, true)->Apply(sizes);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
