// SPDX-License-Identifier: Apache-2.0
// What planning a cut takes: one motion of a blade, 2 mm deep and 10 mm long, into the top of a
// block of more and more tissue. And what shape cuts leave tetrahedra in, by CutOptions::snap.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/mesh/quality.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/surgery/cut.h"

#include "tests/support/small_steps.h"

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
  return Solver(scene, testing::small_steps({.executor = executor::serial()}));
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
  state.counters["tets"] = static_cast<double>(solver.tissue().tets().size());
  state.counters["vertices"] = solver.vertex_count();
  state.counters["new_tets"] = static_cast<double>(divided);
}

// A plane through the middle of a body, square to an axis.
CutSurface plane_through(const Eigen::AlignedBox3f& box, int axis) {
  const Eigen::Vector3f u = box.diagonal().norm() * Eigen::Vector3f::Unit((axis + 1) % 3);
  const Eigen::Vector3f v = box.diagonal().norm() * Eigen::Vector3f::Unit((axis + 2) % 3);
  const Eigen::Vector3f c = box.center();
  return {{c - u - v, c + u - v, c + u + v, c - u + v}, {{0, 1, 2}, {0, 2, 3}}};
}

// What a plan's parts look like, and how many tetrahedra they come of.
struct Parts {
  std::size_t parents = 0;
  std::size_t count = 0;
  double worst_radius_ratio = 1;
  double least_share = 1;  // of the volume of the tetrahedron that a part is of

  void add(const std::vector<Eigen::Vector3d>& positions, std::span<const Tet> tets,
           const TopologyEdit& edit) {
    std::vector<Eigen::Vector3d> all = positions;
    for (const NewVertex& vertex : edit.new_vertices) {
      const Eigen::Vector3d& x = positions[vertex.first];
      all.push_back(x + double{vertex.share} * (positions[vertex.second] - x));
    }
    Index last = kInvalidIndex;  // parts of one follow each other
    for (const NewTet& part : edit.new_tets) {
      parents += part.parent != last ? 1 : 0;
      last = part.parent;
      worst_radius_ratio = std::min(worst_radius_ratio, radius_ratio(all, part.vertices));
      least_share = std::min(
          least_share, tet_volume(all, part.vertices) / tet_volume(positions, tets[part.parent]));
    }
    count += edit.new_tets.size();
  }
};

// Row 2 of table 2, cut by three planes, one at a time. The argument is in hundredths.
void snap(benchmark::State& state) {
  const TetMesh mesh = table2_mesh(2);
  Scene scene;
  scene.add_body("organ", mesh, elastic_material(mesh, 1000, 20e3));
  const Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  Eigen::AlignedBox3f box;
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& x : solver.positions()) {
    box.extend(x);
    positions.push_back(x.cast<double>());
  }
  const CutOptions options{.snap = static_cast<float>(state.range(0)) / 100};
  Parts parts;
  for (auto _ : state) {
    parts = {};
    for (int axis = 0; axis < 3; ++axis) {
      parts.add(positions, solver.tissue().tets(),
                plan_cut(solver, plane_through(box, axis), options).edit);
    }
  }
  state.counters["tets"] = static_cast<double>(parts.parents);
  state.counters["parts"] = static_cast<double>(parts.count);
  state.counters["worst_radius_ratio"] = parts.worst_radius_ratio;
  state.counters["least_share"] = parts.least_share;
}

BENCHMARK(snap)->Arg(5)->Arg(10)->Arg(20)->Arg(30)->Unit(benchmark::kMillisecond);
BENCHMARK(plan_motion)->Arg(10'000)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pbdsurg
BENCHMARK_MAIN();
