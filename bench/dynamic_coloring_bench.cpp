// SPDX-License-Identifier: Apache-2.0
// What 200 edits of one hundredth each leave of a colouring of tetrahedra, and what they cost.
//
//   exchange  100 edits remove tetrahedra and put back those that the edit before has removed, 50
//             only remove, 50 put all of those back
//   refine    100 edits split edges, with all tetrahedra around them, which raises the clique
//             bound; 100 take that back, which lowers it
//
// anywhere (scattered) or in one neighbourhood an edit (regional). Meshes:
//
//   surface_filled/ROW  of table 2, the paper's kind; needs the program tetgen
//   hollow/ROW          of table 2, as this library makes them
//   split/TETS          a box whose edges are split at random until it has five times as many
//                       tetrahedra: very irregular, a hundred of them at a vertex
//   lattice/SIDE        that box unsplit, 24 tetrahedra at each inner vertex: the hard case
//
// Counters: clique bound and colours at the start, the most after any edit and in the end; the most
// colours above the clique bound as it then was, or at the start if larger (excess); deviation of
// the colours' sizes in the end (rsd) and the largest after any edit; the time of an edit, checks,
// removals and follow-up included, for each constraint inserted, and the longest of any edit for
// each constraint that it names; constraints recoloured for each inserted, and the most in any edit
// for each that it names.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/dynamic_coloring.h"

#include "bench/support/sample_meshes.h"

namespace pbdsurg {
namespace {

constexpr int kEdits = 200;

using bench::Dice;
using bench::lattice_mesh;
using bench::split_mesh;
using bench::Splitter;
using bench::Tets;

Tets make_table2(int row, Table2Kind kind) {
  const TetMesh mesh = table2_mesh(row, kind);
  return {{mesh.tets().begin(), mesh.tets().end()}, mesh.vertex_count()};
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

// What is measured of a series of edits.
class Figures {
 public:
  explicit Figures(const DynamicColoring& coloring)
      : full_bound_(coloring.clique_bound()), start_colors_(coloring.color_count()) {
    note(coloring);
  }

  ColoringUpdate apply(DynamicColoring& coloring, const ConstraintEdit& edit) {
    const auto start = std::chrono::steady_clock::now();
    ColoringUpdate update = coloring.apply(edit);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::size_t named = edit.removed.size() + update.inserted.size();
    seconds_ += seconds;
    peak_seconds_ = std::max(peak_seconds_, seconds / static_cast<double>(named));
    inserted_ += update.inserted.size();
    recolored_ += update.recolored.size();
    peak_recolored_ = std::max(
        peak_recolored_, static_cast<double>(update.recolored.size()) / static_cast<double>(named));
    note(coloring);
    return update;
  }

  void report(benchmark::State& state, const DynamicColoring& coloring) const {
    const ColoringExtract extract = coloring.extract();
    if (find_conflict(extract.coloring, extract.constraints())) {
      state.SkipWithError("the colouring is not valid");
      return;
    }
    state.SetIterationTime(seconds_);
    state.counters["tets"] = coloring.constraint_count();
    state.counters["start_bound"] = full_bound_;
    state.counters["most_bound"] = most_bound_;
    state.counters["end_bound"] = coloring.clique_bound();
    state.counters["start_colors"] = start_colors_;
    state.counters["most_colors"] = most_colors_;
    state.counters["end_colors"] = coloring.color_count();
    state.counters["excess"] = most_excess_;
    state.counters["rsd"] = coloring.relative_deviation();
    state.counters["peak_rsd"] = peak_deviation_;
    state.counters["us_per_insertion"] = 1e6 * seconds_ / static_cast<double>(inserted_);
    state.counters["peak_us"] = 1e6 * peak_seconds_;
    state.counters["recolored"] = static_cast<double>(recolored_) / static_cast<double>(inserted_);
    state.counters["peak_recolored"] = peak_recolored_;
  }

 private:
  void note(const DynamicColoring& coloring) {
    const Index bound = coloring.clique_bound();
    most_bound_ = std::max(most_bound_, bound);
    most_colors_ = std::max(most_colors_, coloring.color_count());
    most_excess_ = std::max(most_excess_, coloring.color_count() - std::max(bound, full_bound_));
    peak_deviation_ = std::max(peak_deviation_, coloring.relative_deviation());
  }

  Index full_bound_;
  Index start_colors_;
  Index most_bound_ = 0;
  Index most_colors_ = 0;
  Index most_excess_ = 0;
  double peak_deviation_ = 0;
  double peak_recolored_ = 0;
  double peak_seconds_ = 0;
  double seconds_ = 0;
  std::size_t inserted_ = 0;
  std::size_t recolored_ = 0;
};

void run_exchange(benchmark::State& state, const Tets& mesh, bool regional) {
  for (auto _ : state) {
    DynamicColoring coloring = color_all(mesh);
    Figures figures(coloring);
    Chooser chooser(mesh, regional);
    std::vector<Index> id_of(mesh.tets.size());
    std::iota(id_of.begin(), id_of.end(), 0);
    std::vector<bool> gone(mesh.tets.size(), false);
    std::vector<std::vector<Index>> out;  // what each edit has removed and none put back
    for (int i = 0; i < kEdits; ++i) {
      std::vector<Index> chosen;
      std::vector<Index> removed;
      if (i < 3 * kEdits / 4) {
        chosen = chooser.choose(mesh, gone);
      }
      for (const Index t : chosen) {
        removed.push_back(id_of[t]);
        gone[t] = true;
      }
      std::vector<Index> back;
      std::vector<Tet> tets;
      if (!out.empty() && (i < kEdits / 2 || i >= 3 * kEdits / 4)) {
        back = std::move(out.back());
        out.pop_back();
      }
      for (const Index t : back) {
        tets.push_back(mesh.tets[t]);
        gone[t] = false;
      }
      const ColoringUpdate update = figures.apply(coloring, {removed, {}, mesh.view(tets)});
      for (std::size_t k = 0; k < back.size(); ++k) {
        id_of[back[k]] = update.inserted[k];
      }
      if (!chosen.empty()) {
        out.push_back(std::move(chosen));
      }
    }
    figures.report(state, coloring);
  }
}

// Splits edges, or takes splits back, until a hundredth of the tetrahedra are new or gone. Returns
// those that have changed but kept their number.
std::vector<Index> change(Splitter& splitter, bool refine, bool regional, Dice& dice) {
  const std::size_t count = splitter.mesh().tets.size();
  std::vector<Index> region;
  if (regional) {
    region = splitter.find_region(dice.below(count), count / 20);
  }
  std::vector<bool> seen(count, false);
  std::vector<Index> result;
  while (200 * result.size() < count && (refine || splitter.can_merge())) {
    const Index chosen = regional ? region[dice.below(region.size())] : dice.below(count);
    if (refine && seen[chosen]) {
      continue;  // once an edit
    }
    for (const Index t : refine ? splitter.split(chosen, dice) : splitter.merge()) {
      if (t < static_cast<Index>(count) && !seen[t]) {
        seen[t] = true;
        result.push_back(t);
      }
    }
  }
  std::erase_if(result,
                [&](Index t) { return t >= static_cast<Index>(splitter.mesh().tets.size()); });
  return result;
}

void run_refine(benchmark::State& state, const Tets& given, bool regional) {
  for (auto _ : state) {
    Splitter splitter(given);
    Dice dice(11);
    DynamicColoring coloring = color_all(given);
    Figures figures(coloring);
    std::vector<Index> id_of(given.tets.size());
    std::iota(id_of.begin(), id_of.end(), 0);
    for (int i = 0; i < kEdits && (i < kEdits / 2 || splitter.can_merge()); ++i) {
      std::vector<Index> renewed = change(splitter, i < kEdits / 2, regional, dice);
      const Tets& mesh = splitter.mesh();
      std::vector<Index> removed;
      for (const Index t : renewed) {
        removed.push_back(id_of[t]);
      }
      while (id_of.size() > mesh.tets.size()) {
        removed.push_back(id_of.back());
        id_of.pop_back();
      }
      while (id_of.size() < mesh.tets.size()) {
        renewed.push_back(static_cast<Index>(id_of.size()));
        id_of.push_back(kInvalidIndex);
      }
      std::vector<Tet> tets;
      for (const Index t : renewed) {
        tets.push_back(mesh.tets[t]);
      }
      coloring.add_vertices(std::max(Index{0}, mesh.vertex_count - coloring.vertex_count()));
      const ColoringUpdate update = figures.apply(coloring, {removed, {}, mesh.view(tets)});
      for (std::size_t k = 0; k < renewed.size(); ++k) {
        id_of[renewed[k]] = update.inserted[k];
      }
    }
    figures.report(state, coloring);
  }
}

using Run = void (*)(benchmark::State& state, const Tets& mesh, bool regional);

void BM_table2(benchmark::State& state, Run run, Table2Kind kind, bool regional) {
  try {
    run(state, make_table2(static_cast<int>(state.range(0)), kind), regional);
  } catch (const BackendUnavailable& error) {
    state.SkipWithError(error.what());
  }
}
void BM_split(benchmark::State& state, Run run, bool regional) {
  const auto wanted = static_cast<Index>(state.range(0));
  run(state, split_mesh(wanted), regional);
}
void BM_lattice(benchmark::State& state, Run run, bool regional) {
  run(state, lattice_mesh(static_cast<Index>(state.range(0))), regional);
}

void rows(benchmark::internal::Benchmark* bench) {
  bench->Arg(1)->Arg(2)->Arg(5)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
}
void sizes(benchmark::internal::Benchmark* bench) {
  for (const int tets : {10'000, 60'000, 250'000, 1'000'000}) {
    bench->Arg(tets);
  }
  bench->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
}
void side(benchmark::internal::Benchmark* bench) {
  bench->Arg(15)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
}

#define PBDSURG_BENCH_SERIES(NAME, RUN, REGIONAL)                                                \
  BENCHMARK_CAPTURE(BM_table2, surface_filled_##NAME, RUN, Table2Kind::surface_filled, REGIONAL) \
      ->Apply(rows);                                                                             \
  BENCHMARK_CAPTURE(BM_table2, hollow_##NAME, RUN, Table2Kind::hollow, REGIONAL)->Apply(rows);   \
  BENCHMARK_CAPTURE(BM_split, NAME, RUN, REGIONAL)->Apply(sizes);                                \
  BENCHMARK_CAPTURE(BM_lattice, NAME, RUN, REGIONAL)->Apply(side)

PBDSURG_BENCH_SERIES(exchange_scattered, run_exchange, false);
PBDSURG_BENCH_SERIES(exchange_regional, run_exchange, true);
PBDSURG_BENCH_SERIES(refine_scattered, run_refine, false);
PBDSURG_BENCH_SERIES(refine_regional, run_refine, true);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
