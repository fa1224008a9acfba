// SPDX-License-Identifier: Apache-2.0
// Heat and potential together: a substep of 2 ms while a contact of 5 mm^2 and 10 W moves over
// liver at 10 mm/s, in organs of 20,000 and 200,000 tetrahedra with edges of 1 mm, at rest. Where
// ground is the lower face, the potential is solved in the whole organ, else in the ball around
// the contact.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/tissue/library.h"

#include "apps/support/executors.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

const ThermalProperties& kLiver = tissues::liver().heat;

constexpr double kEdge = 1e-3;      // m
constexpr double kTimeStep = 2e-3;  // s
constexpr double kSpeed = 10e-3;    // m/s
constexpr double kPower = 10;       // W
constexpr double kArea = 5e-6;      // m^2
constexpr int kSubsteps = 250;      // 5 mm, then a fresh organ

constexpr std::array<Index, 3> kSmall{15, 15, 15}, kLarge{33, 33, 31};

// What the contact touches in each substep, as it goes.
std::vector<std::vector<PatchVertex>> find_patches(const TetMesh& mesh,
                                                   const std::array<Index, 3>& cells) {
  const double radius = std::sqrt(kArea / std::numbers::pi) + kEdge / 2;
  std::vector<std::vector<PatchVertex>> patches(kSubsteps);
  for (int i = 0; i < kSubsteps; ++i) {
    const Eigen::Vector3d tip(kEdge * cells[0] / 2 - 2.5e-3 + kSpeed * kTimeStep * i,
                              kEdge * cells[1] / 2, kEdge * cells[2]);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const double distance = (mesh.positions()[v] - tip).norm();
      if (distance < radius && mesh.positions()[v].z() > tip.z() - kEdge / 2) {
        patches[i].push_back({v, std::min(1.0, (radius - distance) / kEdge)});
      }
    }
  }
  return patches;
}

struct Organ {
  Organ(const TetMesh& mesh, bool is_whole, const Executor& executor, Index device_rows)
      : heat(mesh, kLiver, {}, {.executor = executor, .device_rows = device_rows}),
        potential(heat, {.executor = executor, .device_rows = device_rows}),
        conductivities(mesh.tets().size(), kLiver.electrical_conductivity) {
    std::vector<Index> ground;
    for (Index v = 0; v < mesh.vertex_count() && is_whole; ++v) {
      if (mesh.positions()[v].z() < kEdge / 2) {
        ground.push_back(v);
      }
    }
    potential.set_ground(ground);
  }

  void substep(std::span<const PatchVertex> patch) {
    potential.set_patch(patch, kArea);
    const PotentialReport& report = potential.solve(conductivities);
    iterations += report.is_new ? report.iterations : 0;
    sources.clear();
    const std::span<const Index> vertices = potential.vertices();
    const std::span<const double> watts = potential.vertex_heat();  // for 1 V
    for (std::size_t row = 0; report.is_closed && row < vertices.size(); ++row) {
      sources.push_back({vertices[row], kPower * std::max(0.0, watts[row]) / report.conductance});
    }
    heat.step(kTimeStep, sources);
    for (const Index v : heat.active_vertices()) {
      if (heat.temperatures()[v] < kBodyTemperature + 1) {
        continue;  // as a cautery does
      }
      heat.mesh().for_each_element(v, [&](Index t) {
        if (heat.mesh().tets()[t][0] == v) {  // once each, but for the rim
          conductivities[t] =
              electrical_conductivity(kLiver, heat.temperatures()[v], heat.water()[v]);
        }
      });
    }
  }

  HeatField heat;
  PotentialField potential;
  std::vector<double> conductivities;  // [tet_count] S/m
  std::vector<HeatSource> sources;
  double iterations = 0;
};

void BM_substep(benchmark::State& state, const std::array<Index, 3>& cells, bool is_whole,
                const char* executor, Index device_rows) {
  const TetMesh mesh = testing::make_box(cells, kEdge, 0.1);
  const auto patches = find_patches(mesh, cells);
  std::unique_ptr<Organ> organ;
  double iterations = 0, region = 0, active = 0;
  std::size_t i = patches.size();
  for (auto _ : state) {
    if (i == patches.size()) {
      state.PauseTiming();
      try {
        organ = std::make_unique<Organ>(mesh, is_whole, programs::executor_named(executor),
                                        device_rows);
      } catch (const BackendUnavailable& error) {
        state.SkipWithError(error.what());
        break;
      }
      i = 0;
      state.ResumeTiming();
    }
    const double before = organ->iterations;
    organ->substep(patches[i++]);
    iterations += organ->iterations - before;
    region += organ->potential.report().vertex_count;
    active += static_cast<double>(organ->heat.active_vertices().size());
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["tets"] = mesh.tet_count();
  state.counters["region"] = {region, mean};
  state.counters["active"] = {active, mean};
  state.counters["potential_iterations"] = {iterations, mean};
}

#define SUBSTEP(name, cells, is_whole)                                             \
  BENCHMARK_CAPTURE(BM_substep, name##_1_thread, cells, is_whole, "threads:1", 0)  \
      ->Unit(benchmark::kMicrosecond)                                              \
      ->UseRealTime();                                                             \
  BENCHMARK_CAPTURE(BM_substep, name##_2_threads, cells, is_whole, "threads:2", 0) \
      ->Unit(benchmark::kMicrosecond)                                              \
      ->UseRealTime();                                                             \
  BENCHMARK_CAPTURE(BM_substep, name##_device, cells, is_whole, "cuda", 0)         \
      ->Unit(benchmark::kMicrosecond)                                              \
      ->UseRealTime();                                                             \
  BENCHMARK_CAPTURE(BM_substep, name##_automatic, cells, is_whole, "best", 1000)   \
      ->Unit(benchmark::kMicrosecond)                                              \
      ->UseRealTime()
SUBSTEP(20k_ball, kSmall, false);
SUBSTEP(20k_whole, kSmall, true);
SUBSTEP(200k_ball, kLarge, false);
SUBSTEP(200k_whole, kLarge, true);
#undef SUBSTEP

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
