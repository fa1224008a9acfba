// SPDX-License-Identifier: Apache-2.0
// What planning a cut takes: one motion of a blade, 2 mm deep and 10 mm long, into the top of a
// block of more and more tissue.
#include <array>
#include <cmath>

#include <benchmark/benchmark.h>

#include "pbdsurg/edit/cut.h"
#include "pbdsurg/mesh/tetrahedralize.h"

namespace pbdsurg {
namespace {

constexpr double kSpacing = 2e-3;  // m

// @param tets  about so many
Solver make_block(double tets) {
  TetrahedralizeOptions options;
  options.spacing = kSpacing;
  const double side = 0.5 * kSpacing * std::cbrt(tets / 6) * 0.8;
  const TetMesh mesh =
      tetrahedralize(rounded_box_shape({0, 0, 0}, {side, side, side}, 1e-3), options).mesh;
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  return Solver(scene, {.backend = BackendKind::serial});
}

void plan_motion(benchmark::State& state) {
  const Solver solver = make_block(static_cast<double>(state.range(0)));
  float top = 0;
  for (const Eigen::Vector3f& x : solver.positions()) {
    top = std::max(top, x.y());
  }
  const auto edge_at = [](float height) {
    return BladeEdge{{3e-4F, height, -5e-3F}, {3e-4F, height, 5e-3F}};
  };
  const CutSurface surface = sweep_blade(std::array{edge_at(top + 1e-3F), edge_at(top - 2e-3F)});
  std::size_t divided = 0;
  for (auto _ : state) {
    const CutPlan plan = plan_cut(solver, surface);
    divided = plan.edit.new_tets.size();
  }
  state.counters["tets"] = static_cast<double>(solver.tets().size());
  state.counters["vertices"] = solver.vertex_count();
  state.counters["new_tets"] = static_cast<double>(divided);
}

BENCHMARK(plan_motion)->Arg(10'000)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pbdsurg
BENCHMARK_MAIN();
