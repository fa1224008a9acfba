// SPDX-License-Identifier: Apache-2.0
// What heat costs: a step of 1 ms while a hook of 30 W moves over liver at 10 mm/s, in organs of
// 20,000 and 200,000 tetrahedra with edges of 0.5 mm; an edit that removes 17 of them, and a step
// after each of many that remove one.
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/tissue/library.h"

#include "apps/support/executors.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 0.5e-3;     // m
constexpr double kTimeStep = 1e-3;   // s
constexpr double kSpeed = 10e-3;     // m/s
constexpr double kContact = 1.8e-3;  // m, radius of 10 mm^2
constexpr int kPositions = 600;      // steps over the organ, there and back

constexpr std::array<Index, 3> kSmall{16, 16, 13}, kLarge{48, 48, 15};

// Sources of each step, as the hook goes.
std::vector<std::vector<HeatSource>> find_sources(const TetMesh& mesh,
                                                  const std::array<Index, 3>& cells) {
  std::vector<std::vector<HeatSource>> found(kPositions);
  for (int i = 0; i < kPositions; ++i) {
    const double way = kSpeed * kTimeStep * std::abs(i - kPositions / 2.0);
    const Eigen::Vector3d tip(1e-3 + way, cells[1] * kEdge / 2, 0);
    double weight = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const double distance = (mesh.positions()[v] - tip).norm();
      if (distance < kContact) {
        found[i].push_back({v, 1 - distance / kContact});
        weight += found[i].back().power;
      }
    }
    for (HeatSource& source : found[i]) {
      source.power *= 30 / weight;
    }
  }
  return found;
}

// @param options  with active_rise 0: the whole organ takes part
// Of an executor by name; a device solves systems of any size.
HeatOptions heat_on(const char* executor, double active_rise) {
  return {
      .active_rise = active_rise, .executor = programs::executor_named(executor), .device_rows = 0};
}

constexpr double kRise = 0.1;  // K

void BM_step(benchmark::State& state, const std::array<Index, 3>& cells, const char* executor,
             double active_rise) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  const auto sources = find_sources(mesh, cells);
  std::optional<HeatField> made;
  try {
    made.emplace(mesh, tissues::liver().heat, ThermalModel{}, heat_on(executor, active_rise));
  } catch (const BackendUnavailable& error) {
    state.SkipWithError(error.what());
    return;
  }
  const HeatField& cold = *made;
  HeatField field = cold;
  double active = 0, iterations = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    if (i == sources.size()) {
      state.PauseTiming();
      field = cold;
      i = 0;
      state.ResumeTiming();
    }
    const HeatReport report = field.step(kTimeStep, sources[i++]);
    active += report.active_vertices;
    iterations += report.iterations;
  }
  state.counters["tets"] = mesh.tet_count();
  state.counters["active"] = active / static_cast<double>(state.iterations());
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

constexpr int kWarmSteps = 100;

// A field that was heated at one place, in tissue of its own.
struct Warm {
  Warm(const TetMesh& mesh, const std::vector<HeatSource>& sources, const HeatOptions& options)
      : tissue(testing::scene_of(mesh)),
        field(tissue, std::array{ThermalBody{0, tissues::liver().heat}}, {}, options) {
    for (int i = 0; i < kWarmSteps; ++i) {
      field.step(kTimeStep, sources);
    }
  }

  Tissue tissue;
  HeatField field;
};

// An edit that removes 17 tetrahedra around a vertex, and its undo, of tissue and field.
void BM_edit(benchmark::State& state, const std::array<Index, 3>& cells) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  Warm warm(mesh, find_sources(mesh, cells).front(), {});
  TopologyEdit edit;
  const Index middle =
      ((cells[2] / 2) * (cells[1] + 1) + cells[1] / 2) * (cells[0] + 1) + cells[0] / 2;
  warm.field.mesh().for_each_element(middle, [&](Index t) {
    if (edit.remove_tets.size() < 17) {
      edit.remove_tets.push_back(t);
    }
  });
  for (auto _ : state) {
    warm.tissue.apply(edit);
    warm.tissue.undo();
  }
  state.counters["active"] = static_cast<double>(warm.field.active_vertices().size());
}

// An edit that takes a tetrahedron from what is warm, and the step after it.
void BM_edit_and_step(benchmark::State& state, const std::array<Index, 3>& cells,
                      const char* executor) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  const std::vector<HeatSource> sources = find_sources(mesh, cells).front();
  HeatOptions options;
  std::optional<Warm> warm;
  try {
    options = heat_on(executor, kRise);
    warm.emplace(mesh, sources, options);
  } catch (const BackendUnavailable& error) {
    state.SkipWithError(error.what());
    return;
  }
  const std::span<const Index> found = warm->field.active_vertices();
  const std::vector<Index> active(found.begin(), found.end());
  std::size_t i = 0;
  for (auto _ : state) {
    if (++i % 50 == 0) {
      state.PauseTiming();
      warm.emplace(mesh, sources, options);
      state.ResumeTiming();
    }
    TopologyEdit edit;
    warm->field.mesh().for_each_element(active[7 * i % active.size()],
                                        [&](Index t) { edit.remove_tets = {t}; });
    warm->tissue.apply(edit);
    benchmark::DoNotOptimize(warm->field.step(kTimeStep, sources));
  }
  state.counters["active"] = static_cast<double>(warm->field.active_vertices().size());
}

#define STEP(name, cells, executor, rise)                 \
  BENCHMARK_CAPTURE(BM_step, name, cells, executor, rise) \
      ->Unit(benchmark::kMicrosecond)                     \
      ->UseRealTime()
STEP(20k_1_thread, kSmall, "threads:1", kRise);
STEP(20k_2_threads, kSmall, "threads:2", kRise);
STEP(20k_device, kSmall, "cuda", kRise);
STEP(200k_1_thread, kLarge, "threads:1", kRise);
STEP(200k_2_threads, kLarge, "threads:2", kRise);
STEP(200k_device, kLarge, "cuda", kRise);
STEP(20k_all_active_1_thread, kSmall, "threads:1", 0.0);
STEP(20k_all_active_device, kSmall, "cuda", 0.0);
#undef STEP
BENCHMARK_CAPTURE(BM_edit, 20k, kSmall)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_edit, 200k, kLarge)->Unit(benchmark::kMicrosecond);
#define EDIT_AND_STEP(name, cells, executor)                 \
  BENCHMARK_CAPTURE(BM_edit_and_step, name, cells, executor) \
      ->Unit(benchmark::kMicrosecond)                        \
      ->UseRealTime()
EDIT_AND_STEP(20k, kSmall, "threads:1");
EDIT_AND_STEP(20k_device, kSmall, "cuda");
EDIT_AND_STEP(200k, kLarge, "threads:1");
#undef EDIT_AND_STEP

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
