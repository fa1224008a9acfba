// SPDX-License-Identifier: Apache-2.0
// Steps of Neo-Hookean tissue on hollow meshes of table 2, one rim fixed: vertex by vertex against
// tetrahedron by tetrahedron on one thread (row 2, 10 substeps of one sweep), and ten sweeps of
// vertices, or thirty, or as many explicit substeps as a step of 1 ms takes, on a device, from
// start_step() to the report with 200 watched vertices; also of a liver of a million tetrahedra,
// and of row 2 after a hundred cuts. On a device, the end is compared with one thread's. Ten sweeps
// of two sheets that thousands of links join, so soft that these are springs of their vertices or
// stiff. And what it costs to ask whether sweeps have converged.
#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cut.h"

#include "apps/support/executors.h"
#include "bench/edits/blade.h"
#include "bench/support/timing.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

bool has_failed = false;

TetMesh make_liver(Index vertices) {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = vertices;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

Scene make_scene(const TetMesh& mesh, float damping) {
  double start = mesh.positions()[0].x();
  for (const Eigen::Vector3d& x : mesh.positions()) {
    start = std::min(start, x.x());
  }
  Material material;
  material.model = ElasticModel::neo_hookean;
  material.damping = damping;
  Scene scene;
  scene.add_body("organ", mesh, material);
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < start + 4e-3; });
  return scene;
}

void BM_step(benchmark::State& state, SolverMethod method, bool is_serial, float damping) {
  const Executor executor = is_serial ? executor::serial() : executor::threads(1);
  SolverOptions options{.method = method, .substeps = 10, .iterations = 1, .executor = executor};
  Solver solver(make_scene(table2_mesh(2), damping), options);
  state.SetLabel(solver.plan().name + ", " + solver.backend_name());
  state.counters["colors"] = static_cast<double>(solver.plan().phases.size());
  for (auto _ : state) {
    solver.step(5e-3F);
  }
  state.counters["time_per_vertex_and_sweep"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * options.substeps * solver.vertex_count(),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

// Two sheets of a vertex of 2 mm in 5 kPa, face to face; each vertex of one hangs on two of the
// other. 19,208 vertices, 4,753 links.
Scene make_linked_sheets(float compliance) {
  constexpr Index kCells = 48;
  constexpr double kEdge = 2e-3, kGap = 0.5e-3, kHeight = 3 * kEdge;
  const TetMesh upper = testing::make_box({kCells, kCells, 3}, kEdge);
  std::vector<Eigen::Vector3d> lower(upper.positions().begin(), upper.positions().end());
  for (Eigen::Vector3d& x : lower) {
    x.z() -= kHeight + kGap;
  }
  const auto count = static_cast<Index>(lower.size());
  Material material;
  material.model = ElasticModel::neo_hookean;
  Scene scene;
  scene.add_body("upper", upper, material);
  scene.add_body("lower", TetMesh(std::move(lower), {upper.tets().begin(), upper.tets().end()}),
                 material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() > kHeight - 0.5 * kEdge; });
  scene.set_gravity({0, 0, -9.81F});
  constexpr Index kRow = kCells + 1, kLayer = kRow * kRow;
  for (Index v = 0; v < kLayer; ++v) {
    for (Index w = v; w < std::min(v - v % kRow + kRow, v + 2); ++w) {
      const Index other = count + 3 * kLayer + w;
      const double length = (scene.positions()[v] - scene.positions()[other]).norm();
      scene.add_link({v, other, static_cast<float>(length), {1, compliance}});
    }
  }
  return scene;
}

void BM_links(benchmark::State& state, float compliance, int threads) {
  Solver solver(make_linked_sheets(compliance), {.method = SolverMethod::vertex_block,
                                                 .substeps = 1,
                                                 .iterations = 10,
                                                 .executor = executor::threads(threads)});
  state.SetLabel(solver.plan().name + ", " + solver.backend_name());
  state.counters["phases"] = static_cast<double>(solver.plan().phases.size());
  for (auto _ : state) {
    solver.step(5e-3F);
  }
}

void BM_convergence(benchmark::State& state, SolverMethod method) {
  Solver solver(make_scene(table2_mesh(2), 0), {.method = method, .substeps = 10, .iterations = 1});
  for (int i = 0; i < 5; ++i) {
    solver.step(5e-3F);
  }
  for (auto _ : state) {
    state.counters["ratio"] = solver.convergence(5e-3F)[0].ratio();
  }
}

constexpr Index kMillionVertices = 183'000;  // give a million tetrahedra

struct DeviceCase {
  const char* name;
  int row;            // of table 2; 0: a liver of a million tetrahedra
  float damping = 0;  // s
  MathMode math = MathMode::fast;
  Index copies = 1;
  DeviceStrategy strategy = DeviceStrategy::automatic;
  Index sweeps = 10;  // 0: explicit steps
  int cuts = 0;       // before the first step
  int steps = 400;
};

// Through an organ lengthwise, plane by plane, as bench/edits cuts; the same cuts for both.
void cut(const TetMesh& mesh, int cuts, Solver& solver, Solver& other) {
  Blade blade(mesh, solver.positions());
  CutFront front;
  for (int done = 0; done < cuts;) {
    const Blade::Way way = blade.next();
    const CutOptions options{.front = way.begins ? CutFront{} : std::move(front)};
    CutPlan plan = plan_cut(solver, way.surface, options);
    front = std::move(plan.front);
    if (!plan.edit.new_tets.empty()) {
      solver.tissue().apply(plan.edit);
      other.tissue().apply(plan.edit);
      ++done;
    }
  }
}

void BM_device_step(benchmark::State& state, const DeviceCase& what) {
  constexpr float kTimeStep = 1e-3F;        // s
  constexpr float kMostDifference = 1e-5F;  // m, of motions of millimetres
  const bool is_explicit = what.sweeps == 0;
  SolverOptions options{
      .method = is_explicit ? SolverMethod::explicit_steps : SolverMethod::vertex_block,
      .substeps = is_explicit ? kAutomatic : 1,
      .iterations = what.sweeps,
      .copies = what.copies,
      .executor = programs::device(),
      .math = what.math,
      .device_strategy = what.strategy};
  if (what.cuts > 0) {
    options.spare = {.vertices = 8000, .tets = 24'000, .edges = 40'000, .links = 0};
  }
  const TetMesh mesh = what.row > 0 ? table2_mesh(what.row) : make_liver(kMillionVertices);
  const Scene scene = make_scene(mesh, what.damping);
  Solver solver(scene, options);
  options.executor = executor::threads(1);
  options.device_strategy = DeviceStrategy::automatic;
  options.copies = 1;
  Solver alone(scene, options);
  cut(mesh, what.cuts, alone, solver);
  state.SetLabel(solver.plan().name + ", " + solver.backend_name());
  std::vector<Index> watched;
  for (Index i = 0; i < 200; ++i) {
    watched.push_back(i * (solver.vertex_count() / 200));
  }
  solver.watch(watched);
  solver.step(kTimeStep);     // the first prepares
  std::vector<double> times;  // ms
  double substeps = 0;
  for (auto _ : state) {
    times.push_back(time_of([&] {
      solver.start_step(kTimeStep);
      substeps += solver.finish_step().substeps;
      benchmark::DoNotOptimize(solver.watched_positions()[0]);
    }));
    state.SetIterationTime(1e-3 * times.back());
  }
  for (std::size_t i = 0; i <= times.size(); ++i) {
    alone.step(kTimeStep);
  }
  const std::vector<Eigen::Vector3f> here = alone.positions();
  const std::vector<Eigen::Vector3f> there = solver.positions(what.copies - 1);
  float difference = 0;
  for (std::size_t v = 0; v < here.size(); ++v) {
    difference = std::max(difference, (here[v] - there[v]).norm());
  }
  if (!(difference < kMostDifference)) {
    state.SkipWithError("a device's vertices are not where one thread's are");
    has_failed = true;  // which the exit status of the library does not tell
  }
  state.counters["colors"] = static_cast<double>(solver.plan().phases.size());
  state.counters["tets"] = static_cast<double>(solver.tissue().tets().size());
  state.counters["median_ms"] = median(times);
  state.counters["p99_ms"] = quantile(times, 0.99);
  state.counters["nm_off_one_thread"] = 1e9 * difference;
  if (is_explicit) {
    state.counters["substeps"] = substeps / static_cast<double>(times.size());
  }
}

constexpr auto kVertices = SolverMethod::vertex_block;
constexpr auto kTets = SolverMethod::projection;
BENCHMARK_CAPTURE(BM_step, vertices, kVertices, false, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, vertices_damped, kVertices, false, 1e-3F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, vertices_serial, kVertices, true, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, tets, kTets, false, 0.0F)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_step, tets_damped, kTets, false, 1e-3F)->Unit(benchmark::kMillisecond);
constexpr float kSoft = 2e-2F, kStiff = 1e-4F;  // m/N
BENCHMARK_CAPTURE(BM_links, springs, kSoft, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_links, stiff, kStiff, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_links, springs_2_threads, kSoft, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_links, stiff_2_threads, kStiff, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_convergence, vertices, kVertices)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_convergence, tets, kTets)->Unit(benchmark::kMillisecond);

void register_device_steps() {
  for (const DeviceCase& what :
       {DeviceCase{"row_2", 2, 0, MathMode::fast, 1}, DeviceCase{"row_5", 5, 0, MathMode::fast, 1},
        DeviceCase{"row_2_damped", 2, 1e-3F, MathMode::fast, 1},
        DeviceCase{"row_2_strict", 2, 0, MathMode::strict, 1},
        DeviceCase{"row_5_strict", 5, 0, MathMode::strict, 1},
        DeviceCase{"row_2_64_copies", 2, 0, MathMode::fast, 64},
        DeviceCase{"row_2_30_sweeps", 2, 0, MathMode::fast, 1, DeviceStrategy::automatic, 30},
        DeviceCase{"row_5_30_sweeps", 5, 0, MathMode::fast, 1, DeviceStrategy::automatic, 30},
        DeviceCase{.name = "row_2_after_100_cuts", .row = 2, .cuts = 100},
        DeviceCase{.name = "million", .row = 0, .steps = 100},
        DeviceCase{"row_2_graph", 2, 0, MathMode::fast, 1, DeviceStrategy::graph},
        DeviceCase{"row_5_graph", 5, 0, MathMode::fast, 1, DeviceStrategy::graph},
        DeviceCase{"row_2_64_copies_graph", 2, 0, MathMode::fast, 64, DeviceStrategy::graph},
        DeviceCase{"row_2_explicit", 2, 0, MathMode::fast, 1, DeviceStrategy::automatic, 0},
        DeviceCase{"row_5_explicit", 5, 0, MathMode::fast, 1, DeviceStrategy::automatic, 0},
        DeviceCase{"row_2_explicit_strict", 2, 0, MathMode::strict, 1, DeviceStrategy::automatic,
                   0},
        DeviceCase{"row_2_explicit_graph", 2, 0, MathMode::fast, 1, DeviceStrategy::graph, 0},
        DeviceCase{"row_2_explicit_64_copies", 2, 0, MathMode::fast, 64, DeviceStrategy::automatic,
                   0}}) {
    benchmark::RegisterBenchmark((std::string("device/") + what.name).c_str(), BM_device_step, what)
        ->Iterations(what.steps)
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  try {
    static_cast<void>(pbdsurg::programs::device());
    pbdsurg::bench::register_device_steps();
  } catch (const pbdsurg::BackendUnavailable& error) {
    std::fprintf(stderr, "no steps on a device: %s\n", error.what());
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  return pbdsurg::bench::has_failed ? 1 : 0;
}
